// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "raster_samples.h"
#include "raster_tiles.h"

namespace xview::raster {

/// Neighbouring rows of a tile.
struct RowRun {
  std::int64_t first;
  std::int64_t count;
};

/// A tile of cells where the query centre may be.
struct OutputTile {
  std::int64_t tx, ty;
  std::int64_t bound;  ///< no score in the tile is above this
  std::vector<RowRun> rows;
};

/// The tiles where a query centre can score, the most promising first so that the threshold of the
/// search rises early.
std::vector<OutputTile> outputTiles(const LikelihoodRaster& raster, const PreparedSamples& prepared,
                                    const RasterSearchOptions& options);

}  // namespace xview::raster
