// SPDX-License-Identifier: BSD-3-Clause
#include "graph/plan_ground.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace xview {
namespace {

constexpr float kLatticeM = 2.f;
constexpr std::size_t kFewest = 4;  ///< heights that a lattice cell needs
constexpr float kStepM =
    0.7f;  ///< a cell further than this from its neighbourhood is replaced by it
constexpr float kUnset = std::numeric_limits<float>::quiet_NaN();

float quantile(std::vector<float>& values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size()));
  std::nth_element(values.begin(), std::min(at, values.end() - 1), values.end());
  return *std::min(at, values.end() - 1);
}

std::int32_t latticeCell(float p) { return static_cast<std::int32_t>(std::floor(p / kLatticeM)); }

using HeightLists = std::vector<std::vector<float>>;

/// Heights of the ground classes per lattice cell; of all points if no ground class was seen
/// anywhere.
HeightLists gatherHeights(const std::vector<PlanVoxel>& voxels, CellIndex& index,
                          bool& only_ground) {
  only_ground = std::any_of(voxels.begin(), voxels.end(),
                            [](const PlanVoxel& v) { return isGround(v.kind); });
  HeightLists lists;
  for (const PlanVoxel& v : voxels) {
    const auto cell = static_cast<std::size_t>(index.findOrAdd(latticeCell(v.x), latticeCell(v.y)));
    if (lists.size() <= cell) lists.resize(cell + 1);
    if (!only_ground || isGround(v.kind)) lists[cell].push_back(v.z);
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
    const float typical = quantile(around, share);
    if (std::isnan(result[i]) || std::abs(result[i] - typical) > kStepM) result[i] = typical;
  }
  return result;
}

/// Moves each height to the median of the points in the ground layer around it.
void centreOnLayer(const HeightLists& lists, double gate_m, std::vector<float>& heights) {
  std::vector<float> layer;
  for (std::size_t i = 0; i < lists.size(); ++i) {
    if (lists[i].size() < kFewest || std::isnan(heights[i])) continue;
    layer.clear();
    for (const float z : lists[i]) {
      if (std::abs(z - heights[i]) < 2 * gate_m) layer.push_back(z);
    }
    if (layer.size() >= kFewest) heights[i] = quantile(layer, 0.5);
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
  const float typical = known.empty() ? 0.f : quantile(known, 0.5);
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

GroundRule groundRule(const PlanOptions& options, bool aerial) {
  // From the air, stereo noise in height exceeds that near the ground, and a low quantile would be
  // biased by a metre.
  return aerial ? GroundRule{0.5, 2 * options.ground_gate_m}
                : GroundRule{0.25, options.ground_gate_m};
}

GroundSurface::GroundSurface(const std::vector<PlanVoxel>& voxels, const GroundRule& rule) {
  bool only_ground = true;
  HeightLists lists = gatherHeights(voxels, index_, only_ground);
  lists.resize(index_.size());
  const double share = only_ground ? rule.quantile : std::min(0.05, rule.quantile);
  heights_.assign(lists.size(), kUnset);
  for (std::size_t i = 0; i < lists.size(); ++i) {
    if (lists[i].size() >= kFewest) heights_[i] = quantile(lists[i], share);
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

}  // namespace xview
