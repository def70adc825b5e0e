// SPDX-License-Identifier: BSD-3-Clause
#include "graph/plan_cells.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

#include "xview/types/median.h"

namespace xview::graph {
namespace {

constexpr float kLatticeM = 2.f;
constexpr std::size_t kFewest = 4;  ///< heights that a lattice cell needs
constexpr float kStepM =
    0.7f;  ///< a cell further than this from its neighbourhood is replaced by it
constexpr double kLowestShare =
    0.05;  ///< quantile that is the ground where no ground class was seen
constexpr double kGroundGate_m =
    0.6;  ///< ground classes farther than this above the surface are obstacles
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

bool anyGround(const PlanVoxels& voxels) {
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    if (isGround(voxels[i].kind())) return true;
  }
  return false;
}

/// Heights of the ground classes, or of all points. Every cell with any point gets a number.
HeightLists gatherHeights(const PlanVoxels& voxels, bool only_ground, CellIndex& index) {
  constexpr std::uint32_t kLeftOut = std::numeric_limits<std::uint32_t>::max();
  HeightLists lists;
  lists.starts.assign(1, 0);
  std::vector<std::uint32_t> cell_of(voxels.size(), kLeftOut);
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    const PlanVoxel& v = voxels[i];
    const auto cell =
        static_cast<std::uint32_t>(index.findOrAdd(latticeCell(v.x), latticeCell(v.y)));
    if (cell == lists.cells()) lists.starts.push_back(0);
    if (only_ground && !isGround(v.kind())) continue;
    cell_of[i] = cell;
    ++lists.starts[cell + 1];
  }
  std::partial_sum(lists.starts.begin(), lists.starts.end(), lists.starts.begin());
  lists.heights.resize(lists.starts.back());
  std::vector<std::size_t> next = lists.starts;
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    if (cell_of[i] != kLeftOut) lists.heights[next[cell_of[i]]++] = voxels[i].z;
  }
  return lists;
}

/// Replaces cells that are missing or stick out by a quantile of their 5x5 neighbourhood.
std::vector<float> smoothed(const CellIndex& index, const std::vector<float>& raw, double share) {
  std::vector<float> result = raw, around;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    around.clear();
    const CellIndex::Cell cell = index.cells()[i];
    for (int dy = -2; dy <= 2; ++dy) {
      for (int dx = -2; dx <= 2; ++dx) {
        const std::int32_t j = index.find(cell.x + dx, cell.y + dy);
        if (j >= 0 && !std::isnan(raw[j])) around.push_back(raw[j]);
      }
    }
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
    if (lists.size(i) < kFewest || std::isnan(heights[i])) continue;
    layer.clear();
    std::copy_if(lists.begin(i), lists.end(i), std::back_inserter(layer),
                 [&](float z) { return std::abs(z - heights[i]) < 2 * gate_m; });
    if (layer.size() >= kFewest) heights[i] = quantileOf(layer, 0.5);
  }
}

/// Spreads known heights to the other occupied cells, nearest first (breadth first); cells that
/// cannot be reached get the median.
void fillGaps(const CellIndex& index, std::vector<float>& heights) {
  std::vector<std::int32_t> queue;
  for (std::size_t i = 0; i < heights.size(); ++i) {
    if (!std::isnan(heights[i])) queue.push_back(static_cast<std::int32_t>(i));
  }
  std::vector<float> known;
  for (const std::int32_t i : queue) known.push_back(heights[i]);
  const float typical = known.empty() ? 0.f : quantileOf(known, 0.5);
  for (std::size_t k = 0; k < queue.size(); ++k) {
    const CellIndex::Cell cell = index.cells()[queue[k]];
    for (int dy = -2; dy <= 2; ++dy) {
      for (int dx = -2; dx <= 2; ++dx) {
        const std::int32_t j = index.find(cell.x + dx, cell.y + dy);
        if (j < 0 || !std::isnan(heights[j])) continue;
        heights[j] = heights[queue[k]];
        queue.push_back(j);
      }
    }
  }
  std::replace_if(
      heights.begin(), heights.end(), [](float z) { return std::isnan(z); }, typical);
}

}  // namespace

GroundRule groundRule(bool aerial) {
  // From the air, stereo noise in height exceeds that near the ground, and a low quantile would be
  // biased by a metre.
  return aerial ? GroundRule{0.5, 2 * kGroundGate_m} : GroundRule{0.25, kGroundGate_m};
}

GroundSurface::GroundSurface(const PlanVoxels& voxels, const GroundRule& rule) {
  const bool only_ground = anyGround(voxels);
  HeightLists lists = gatherHeights(voxels, only_ground, index_);
  const double share = only_ground ? rule.quantile : std::min(kLowestShare, rule.quantile);
  heights_.assign(lists.cells(), kUnset);
  for (std::size_t i = 0; i < lists.cells(); ++i) {
    if (lists.size(i) >= kFewest) heights_[i] = quantileOf(lists.begin(i), lists.end(i), share);
  }
  heights_ = smoothed(index_, heights_, rule.quantile < 0.5 ? 0.4 : 0.5);
  if (only_ground) centreOnLayer(lists, rule.gate_m, heights_);
  fillGaps(index_, heights_);
}

float GroundSurface::latticeHeight(std::int32_t x, std::int32_t y, float fallback) const {
  const std::int32_t i = index_.find(x, y);
  return i < 0 ? fallback : heights_[i];
}

float GroundSurface::heightAt(float x, float y) const {
  const float fx = x / kLatticeM - 0.5f, fy = y / kLatticeM - 0.5f;
  const auto ix = static_cast<std::int32_t>(std::floor(fx)),
             iy = static_cast<std::int32_t>(std::floor(fy));
  const float rx = fx - static_cast<float>(ix), ry = fy - static_cast<float>(iy);
  const float own = latticeHeight(latticeCell(x), latticeCell(y), 0.f);
  const float a = latticeHeight(ix, iy, own), b = latticeHeight(ix + 1, iy, own);
  const float c = latticeHeight(ix, iy + 1, own), d = latticeHeight(ix + 1, iy + 1, own);
  return (a * (1 - rx) + b * rx) * (1 - ry) + (c * (1 - rx) + d * rx) * ry;
}

}  // namespace xview::graph
