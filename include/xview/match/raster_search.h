// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "xview/types/place.h"

namespace xview {

/// One byte per cell and channel on an unbounded plane, in 64x64-cell tiles that exist only where
/// something was written: a road network costs its streets, not its bounding box. Cells without a
/// tile have the channel's background value.
class LikelihoodRaster {
 public:
  /// At most 4096 channels; cell_m > 0 [m]. Throws UsageError otherwise.
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

  struct Tiles;
  /// For the search only.
  const Tiles& tiles() const { return *tiles_; }

 private:
  std::unique_ptr<Tiles> tiles_;
};

/// A query sample, relative to the centre of the query, in metres.
struct RasterSample {
  float x = 0, y = 0;
  std::uint16_t channel = 0;
};

struct RasterSearchOptions {
  double max_yaw_step_rad = 0.105;  ///< 6 degrees; smaller if the query is large
  /// The query centre is looked for this close to cells above the background only (up to 16 cells
  /// more). Saves time where the centre cannot be far from the map's content; the default looks
  /// wherever a sample can score.
  double margin_m = std::numeric_limits<double>::infinity();
  std::size_t keep_cells = 4000;  ///< best (x, y, yaw) cells kept before thinning
  std::size_t keep_poses = 200;   ///< distinct poses returned
  int threads = 1;
  PlacePrior centre_prior;  ///< restricts the pose of the query centre
};

/// Exhaustive search over (x, y, yaw): the score of a pose is the sum over samples of the raster
/// value of their channel at the transformed sample minus the background of the channel (so that
/// unseen area counts zero). Returns the best distinct poses of positive score (non-maximum
/// suppression within 1.6 cells and 1.6 yaw steps), best first; ties are broken by position, so
/// that neither threads nor the instruction set matter. Positions are cell centres;
/// PlacePose::score is that integer sum. Time grows with the area near written tiles, the number of
/// samples and the query radius (finer yaw); at most 2000 cells of radius are possible. Throws
/// UsageError for samples that are farther, not finite, or of an unknown channel.
std::vector<PlacePose> searchRaster(const LikelihoodRaster& raster,
                                    const std::vector<RasterSample>& samples,
                                    const RasterSearchOptions& options);

/// A finer raster of the same place with its own samples of the same query (thicker, if evidence
/// per square metre should stay the same).
struct FineLevel {
  const LikelihoodRaster& raster;
  const std::vector<RasterSample>& samples;
  double max_yaw_step_rad = 0.105;
};

/// For large maps: the best keep_cells cells of the coarse raster are looked at again on the fine
/// one (all fine cells and yaws that the coarse cell stands for) and thinned there. Scores are
/// those of the fine raster. The cell size of the coarse raster must be a whole multiple of the
/// fine one.
std::vector<PlacePose> searchRaster(const LikelihoodRaster& coarse,
                                    const std::vector<RasterSample>& samples, const FineLevel& fine,
                                    const RasterSearchOptions& options);

/// The same score for one pose, cell by cell.
int rasterScore(const LikelihoodRaster& raster, const std::vector<RasterSample>& samples,
                const PlacePose& pose);

}  // namespace xview
