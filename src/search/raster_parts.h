// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <tuple>
#include <vector>

#include "search/raster.h"

namespace xview::search {

/// Throws UsageError for samples that cannot be looked up.
void check(const RasterLevel& level);

/// Evenly spaced headings: the circle, or the tolerance around the expected one.
struct YawGrid {
  double first = 0, step = 0;
  int count = 0;
  double yaw(int index) const { return first + index * step; }
};

/// A sample at 70 % of the query radius moves by at most 1.2 cells from one heading to the next.
double yawStep(const RasterLevel& level);
YawGrid yawGrid(double wanted_step, const std::optional<PlacePrior::Heading>& prior);

/// Samples sorted by channel, with the channels that occur numbered densely.
struct PreparedSamples {
  std::vector<RasterSample> samples;
  std::vector<std::uint16_t> channels;   ///< the different ones, rising
  std::vector<std::uint32_t> slot;       ///< per sample: index of its channel in `channels`
  std::vector<std::uint32_t> count;      ///< per slot: number of samples
  std::vector<std::uint8_t> background;  ///< per slot
  std::int64_t background_sum = 0;       ///< over samples
  std::int64_t reach = 0;                ///< largest possible offset [cells]

  PreparedSamples(const LikelihoodRaster& raster, std::vector<RasterSample> unsorted);
  std::size_t size() const { return samples.size(); }
};

/// The cell of a sample relative to the cell of the query centre.
struct CellOffset {
  std::int32_t x, y;
};

/// All offsets, heading by heading.
std::vector<CellOffset> offsetTable(const PreparedSamples& prepared, const YawGrid& grid,
                                    double cell_m);

constexpr double kRoundingSlack =
    1e-6;  ///< [cells] makes exact halves round up in spite of rounding errors

/// A cell of the pose space and its score. The order is total, so that the best K are the same
/// whoever finds them.
struct Candidate {
  std::int32_t score;
  std::int32_t yaw;
  std::int64_t x, y;

  bool operator<(const Candidate& b) const {
    return std::tie(b.score, y, x, yaw) < std::tie(score, b.y, b.x, b.yaw);
  }
};

/// The best K of all candidates that are offered. A threshold below which nothing can be among them
/// rises on the way.
class BestCandidates {
 public:
  /// Candidates below `least_share` of the best score may be forgotten, too.
  explicit BestCandidates(std::size_t keep, double least_share = 0)
      : keep_(keep > 0 ? keep : 1), least_share_(least_share) {}

  std::int32_t threshold() const { return threshold_; }

  void offer(const Candidate& candidate) {
    if (candidate.score < threshold_) return;
    candidates_.push_back(candidate);
    threshold_ = std::max(threshold_, static_cast<std::int32_t>(least_share_ * candidate.score));
    if (candidates_.size() >= 2 * keep_) prune();
  }

  void merge(const BestCandidates& other);
  std::vector<Candidate> sorted() &&;

 private:
  void prune();

  std::size_t keep_;
  double least_share_;
  std::int32_t threshold_ = 1;
  std::vector<Candidate> candidates_;
};

/// Greedy non-maximum suppression within 1.6 cells and 1.6 yaw steps; candidates are sorted.
std::vector<PlacePose> distinctPoses(const std::vector<Candidate>& candidates, const YawGrid& grid,
                                     double cell_m, std::size_t keep);

/// A contiguous copy of a square of the raster, one layer per channel of the query: so the inner
/// loop knows nothing of tiles.
class Window {
 public:
  Window(const LikelihoodRaster& raster, const PreparedSamples& prepared, std::int64_t side);

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
  /// True if most of the layer differs from the background, so that looking for gaps does not pay.
  bool isDense(std::size_t slot) const { return dense_[slot] != 0; }

 private:
  void copyTile(std::size_t slot, const LikelihoodRaster::Tile* tile, std::int64_t tx,
                std::int64_t ty);
  void noteTile(std::size_t slot, const LikelihoodRaster::Tile& tile);
  void countParts(std::size_t slot);

  const LikelihoodRaster& raster_;
  const PreparedSamples& prepared_;
  std::int64_t side_;
  std::int64_t parts_;  ///< 8x8 parts across, including cut ones
  std::int64_t first_x_ = 0, first_y_ = 0;
  std::vector<std::uint8_t> cells_;
  std::vector<std::uint8_t> highest_, dense_;
  /// Per slot (parts_ + 1)^2 sums: differing parts left of and above each corner.
  std::vector<std::uint32_t> part_sums_;
};

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
                                    const RasterLevels& levels);

}  // namespace xview::search
