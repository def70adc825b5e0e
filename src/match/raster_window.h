// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "raster_samples.h"
#include "raster_tiles.h"

namespace xview::raster {

/// A contiguous copy of a square of the raster, one layer per channel of the query: so the inner
/// loop knows nothing of tiles.
class Window {
 public:
  Window(const LikelihoodRaster::Tiles& tiles, const PreparedSamples& prepared, std::int64_t side);

  /// Copies the cells [first_x, first_x + side) x [first_y, first_y + side).
  void load(std::int64_t first_x, std::int64_t first_y);

  std::int64_t side() const { return side_; }
  /// A cell relative to the first one.
  const std::uint8_t* cell(std::size_t slot, std::int64_t x, std::int64_t y) const {
    return cells_.data() + static_cast<std::int64_t>(slot) * side_ * side_ + y * side_ + x;
  }
  /// No cell of the layer is above this.
  std::uint8_t highest(std::size_t slot) const { return highest_[slot]; }
  /// False only if all cells of the rectangle are background; relative to the first cell.
  bool mayDiffer(std::size_t slot, std::int64_t x, std::int64_t y, std::int64_t width,
                 std::int64_t height) const;
  /// True if so much of the layer differs from the background that looking for gaps does not pay.
  bool isDense(std::size_t slot) const { return dense_[slot] != 0; }

 private:
  void copyTile(std::size_t slot, const LikelihoodRaster::Tiles::Tile* tile, std::int64_t tx,
                std::int64_t ty);
  void noteTile(std::size_t slot, const LikelihoodRaster::Tiles::Tile& tile);
  void countParts(std::size_t slot);

  const LikelihoodRaster::Tiles& tiles_;
  const PreparedSamples& prepared_;
  std::int64_t side_;
  std::int64_t parts_;  ///< 8x8 parts across, including cut ones
  std::int64_t first_x_ = 0, first_y_ = 0;
  std::vector<std::uint8_t> cells_;
  std::vector<std::uint8_t> highest_, dense_;
  /// Per slot (parts_ + 1)^2 sums: differing parts left of and above each corner.
  std::vector<std::uint32_t> part_sums_;
};

}  // namespace xview::raster
