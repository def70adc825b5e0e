// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "xview/types/place.h"

namespace xview {

/// One byte per cell and channel on an unbounded plane, in 64x64-cell tiles that exist only where something was written: a road network
/// costs its streets, not its bounding box. Cells without a tile have the channel's background value.
class LikelihoodRaster {
 public:
  LikelihoodRaster(double cell_m, std::vector<std::uint8_t> background_of_channel);
  ~LikelihoodRaster();
  LikelihoodRaster(LikelihoodRaster&&) noexcept;
  LikelihoodRaster& operator=(LikelihoodRaster&&) noexcept;

  double cellSize() const;
  std::size_t channels() const;
  std::uint8_t background(std::size_t channel) const;
  /// Cell (cx, cy) covers [cx, cx + 1) x [cy, cy + 1) times cellSize().
  void set(std::size_t channel, std::int32_t cx, std::int32_t cy, std::uint8_t value);
  /// Keeps the larger of the old and the new value.
  void raise(std::size_t channel, std::int32_t cx, std::int32_t cy, std::uint8_t value);
  std::uint8_t at(std::size_t channel, std::int32_t cx, std::int32_t cy) const;
  std::size_t bytes() const;

 private:
  friend class RasterSearch;
  struct Tiles;
  std::unique_ptr<Tiles> tiles_;
};

/// A query sample, relative to the centre of the query, in metres.
struct RasterSample {
  float x = 0, y = 0;
  std::uint16_t channel = 0;
};

struct RasterSearchOptions {
  double max_yaw_step_rad = 0.105;  ///< 6 degrees; smaller if the query is large
  std::size_t keep_cells = 4000;    ///< best (x, y, yaw) cells kept before thinning
  std::size_t keep_poses = 200;     ///< distinct poses returned
  int threads = 1;
  PlacePrior centre_prior;          ///< restricts the pose of the query centre
};

/// Exhaustive search over (x, y, yaw): the score of a pose is the sum over samples of the raster value of their channel at the transformed sample
/// minus the background of the channel (so that unseen area counts zero). Returns the best distinct poses (non-maximum suppression within
/// 1.6 cells and 1.6 yaw steps), best first; ties are broken by position, so that neither threads nor the instruction set matter.
/// PlacePose::score is that integer sum.
std::vector<PlacePose> searchRaster(const LikelihoodRaster& raster, const std::vector<RasterSample>& samples,
                                    const RasterSearchOptions& options);

/// The same score for one pose, cell by cell.
int rasterScore(const LikelihoodRaster& raster, const std::vector<RasterSample>& samples, const PlacePose& pose);

}  // namespace xview
