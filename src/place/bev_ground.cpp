// SPDX-License-Identifier: BSD-3-Clause
#include "place/bev_cells.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

#include "base/median.h"
#include "place/bev_grid.h"

namespace xview {
namespace {

constexpr float kLatticeM = 2.f;
constexpr std::size_t kFewestHeights = 4;  ///< heights that a lattice cell needs
constexpr float kStepM =
    0.7f;  ///< a cell further than this from its neighbourhood is replaced by it
constexpr double kLowestShare =
    0.05;                            ///< quantile that is the ground where no ground class was seen
constexpr std::int32_t kAround = 2;  ///< cells to each side of the neighbourhood of one
constexpr float kUnset = std::numeric_limits<float>::quiet_NaN();

std::int32_t latticeCell(float p) { return floorToInt(p / kLatticeM); }

/// Heights of the points of each lattice cell.
struct HeightLists {
  std::vector<std::size_t> starts;  ///< of each cell, and the end
  std::vector<float> heights;

  std::size_t cells() const { return starts.size() - 1; }
  float* begin(std::size_t cell) { return heights.data() + starts[cell]; }
  float* end(std::size_t cell) { return heights.data() + starts[cell + 1]; }
  std::size_t size(std::size_t cell) const { return starts[cell + 1] - starts[cell]; }
};

bool anyGround(const BevVoxels& voxels) {
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    if (isGround(voxels[i].kind())) return true;
  }
  return false;
}

/// Heights of the ground classes, or of all points. Every cell with any point gets a number.
HeightLists gatherHeights(const BevVoxels& voxels, bool only_ground, CellIndex& index) {
  std::vector<std::int32_t> cell_of(voxels.size());
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    const BevVoxel& v = voxels[i];
    cell_of[i] = index.findOrAdd(latticeCell(v.x), latticeCell(v.y));
    if (only_ground && !isGround(v.kind())) cell_of[i] = -1;
  }
  Grouped groups(cell_of, index.size());
  HeightLists lists{std::move(groups.starts), {}};
  lists.heights.reserve(groups.order.size());
  for (const std::uint32_t i : groups.order) lists.heights.push_back(voxels[i].z);
  return lists;
}

/// Replaces cells that are missing or stick out by a quantile of their 5x5 neighbourhood.
std::vector<float> smoothed(const CellIndex& index, const std::vector<float>& raw, double share) {
  std::vector<float> result = raw, around;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    around.clear();
    index.forAround(i, kAround, [&](std::int32_t j) {
      if (!std::isnan(raw[j])) around.push_back(raw[j]);
    });
    if (around.size() < 3) continue;
    const float typical = quantileOf(around, share);
    if (std::isnan(result[i]) || std::abs(result[i] - typical) > kStepM) result[i] = typical;
  }
  return result;
}

/// Moves each height to the median of the points in the ground layer around it.
void centreOnLayer(HeightLists& lists, double gate_m, std::vector<float>& heights) {
  std::vector<float> layer;
  for (std::size_t i = 0; i < lists.cells(); ++i) {
    if (lists.size(i) < kFewestHeights || std::isnan(heights[i])) continue;
    layer.clear();
    std::copy_if(lists.begin(i), lists.end(i), std::back_inserter(layer),
                 [&](float z) { return std::abs(z - heights[i]) < 2 * gate_m; });
    if (layer.size() >= kFewestHeights) heights[i] = quantileOf(layer, 0.5);
  }
}

}  // namespace

GroundRule groundRule(bool aerial) {
  // From the air, stereo noise in height exceeds that near the ground, and a low quantile would be
  // biased by a metre.
  return aerial ? GroundRule{0.5, 2 * kGroundGate_m} : GroundRule{0.25, kGroundGate_m};
}

HeightLattice groundSurface(const BevVoxels& voxels, const GroundRule& rule) {
  HeightLattice ground{kLatticeM, {}, {}};
  const bool only_ground = anyGround(voxels);
  HeightLists lists = gatherHeights(voxels, only_ground, ground.index);
  const double share = only_ground ? rule.quantile : std::min(kLowestShare, rule.quantile);
  std::vector<float> heights(lists.cells(), kUnset);
  for (std::size_t i = 0; i < lists.cells(); ++i) {
    if (lists.size(i) >= kFewestHeights)
      heights[i] = quantileOf(lists.begin(i), lists.end(i), share);
  }
  ground.heights = smoothed(ground.index, heights, rule.quantile < 0.5 ? 0.4 : 0.5);
  if (only_ground) centreOnLayer(lists, rule.gate_m, ground.heights);
  ground.fillGaps(kAround);
  return ground;
}

}  // namespace xview
