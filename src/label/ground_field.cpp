// SPDX-License-Identifier: BSD-3-Clause
#include "label/ground_field.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "xview/types/median.h"

namespace xview::label {
namespace {

constexpr int kReach = 3;  ///< cells over which ground runs on unseen, such as between two beams
constexpr float kRough_m = 0.12F,
                kSlope = 0.12F;            ///< neighbouring heights of one ground differ less
constexpr std::size_t kSpurious = 2;       ///< points of a cell that may lie below its ground
constexpr float kStep_m = 0.3F;            ///< what is higher by more is a step
constexpr std::size_t kFewestCells = 6;    ///< smaller patches are no ground of their own
constexpr float kHighestTerrace_m = 1.5F;  ///< large patches behind a lower step are terraces,
constexpr std::size_t kTerraceCells = 30;  ///< behind a higher one roofs and crowns

struct Offset {
  int x, y;
  float distance_m;
};

/// The neighbours on one side, so that every pair is met once.
std::vector<Offset> halfRing(int reach) {
  std::vector<Offset> offsets;
  for (int y = 0; y <= reach; ++y) {
    for (int x = -reach; x <= reach; ++x) {
      if (y > 0 || x > 0)
        offsets.push_back({x, y, GroundField::kCell_m * std::hypot(float(x), float(y))});
    }
  }
  return offsets;
}

std::int32_t rootOf(std::vector<std::int32_t>& parents, std::int32_t i) {
  while (parents[i] != i) i = parents[i] = parents[parents[i]];
  return i;
}

/// What speaks for and against a component being ground.
struct Patch {
  std::size_t cells = 0, above = 0, below = 0;  ///< neighbours of others that it lies above, below
  std::vector<float> steps;                     ///< to those that it lies above [m]
  float lowest = INFINITY;
};

bool isGround(Patch& patch) {
  if (patch.cells < kFewestCells) return false;
  if (patch.below >= patch.above) return true;
  return patch.cells >= kTerraceCells && quantileOf(patch.steps, 0.5) < kHighestTerrace_m;
}

}  // namespace

GroundField::GroundField(const pcl::PointCloud<Point>& points) {
  findLowest(points);
  joinCells();
  chooseGround();
  fillGaps();
}

std::int32_t GroundField::cellAt(float x, float y) const {
  return index_.find(floorToInt(x / kCell_m), floorToInt(y / kCell_m));
}

void GroundField::findLowest(const pcl::PointCloud<Point>& points) {
  std::vector<std::uint32_t> cell_of(points.size());
  std::vector<std::size_t> first(1, 0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point& p = points[i];
    cell_of[i] = static_cast<std::uint32_t>(
        index_.findOrAdd(floorToInt(p.x / kCell_m), floorToInt(p.y / kCell_m)));
    if (cell_of[i] + 1 == first.size()) first.push_back(0);
    ++first[cell_of[i] + 1];
  }
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<float> heights(points.size()), sigmas(index_.size(), 0);
  std::vector<std::size_t> next = first;
  for (std::size_t i = 0; i < points.size(); ++i) {
    heights[next[cell_of[i]]++] = points[i].z;
    sigmas[cell_of[i]] += points[i].sigma;
  }
  lowest_.resize(index_.size());
  sigma_.resize(index_.size());
  for (std::size_t c = 0; c < index_.size(); ++c) {
    const std::size_t count = first[c + 1] - first[c];
    float* const begin = heights.data() + first[c];
    float* const nth = begin + std::min(kSpurious, (count - 1) / 3);
    std::nth_element(begin, nth, begin + count);
    lowest_[c] = *nth;
    sigma_[c] = sigmas[c] / static_cast<float>(count);
  }
}

float GroundField::toleranceOf(std::size_t cell, std::size_t other, float distance_m) const {
  return kRough_m + kSlope * distance_m + 2 * std::hypot(sigma_[cell], sigma_[other]);
}

void GroundField::joinCells() {
  const std::vector<Offset> offsets = halfRing(kReach);
  std::vector<std::int32_t>& parents = component_of_;
  parents.resize(index_.size());
  std::iota(parents.begin(), parents.end(), 0);
  for (std::size_t i = 0; i < index_.size(); ++i) {
    const CellIndex::Cell cell = index_.cells()[i];
    for (const Offset& o : offsets) {
      const std::int32_t j = index_.find(cell.x + o.x, cell.y + o.y);
      if (j < 0 || std::abs(lowest_[i] - lowest_[j]) >= toleranceOf(i, j, o.distance_m)) continue;
      const std::int32_t a = rootOf(parents, static_cast<std::int32_t>(i)), b = rootOf(parents, j);
      parents[std::max(a, b)] = std::min(a, b);
    }
  }
  for (std::size_t i = 0; i < index_.size(); ++i)
    parents[i] = rootOf(parents, static_cast<std::int32_t>(i));
}

void GroundField::chooseGround() {
  const std::vector<Offset> offsets = halfRing(kReach);
  std::vector<Patch> patches(index_.size());
  for (std::size_t i = 0; i < index_.size(); ++i) {
    Patch& patch = patches[component_of_[i]];
    ++patch.cells;
    patch.lowest = std::min(patch.lowest, lowest_[i]);
    const CellIndex::Cell cell = index_.cells()[i];
    for (const Offset& o : offsets) {
      const std::int32_t j = index_.find(cell.x + o.x, cell.y + o.y);
      if (j < 0 || component_of_[i] == component_of_[j]) continue;
      const float step = lowest_[i] - lowest_[j];
      if (std::abs(step) < kStep_m + kSlope * o.distance_m) continue;
      Patch& high = step > 0 ? patch : patches[component_of_[j]];
      Patch& low = step > 0 ? patches[component_of_[j]] : patch;
      // Specks tell nothing of what is beside them.
      ++high.above;
      high.steps.push_back(std::abs(step));
      ++low.below;
    }
  }
  std::vector<std::uint8_t> chosen(patches.size(), 0);
  std::size_t largest = 0, any = 0;
  for (std::size_t c = 0; c < patches.size(); ++c) {
    if (patches[c].cells > patches[largest].cells) largest = c;
    chosen[c] = isGround(patches[c]);
    any += chosen[c];
  }
  if (any == 0 && !patches.empty()) chosen[largest] = 1;
  is_ground_.resize(index_.size());
  for (std::size_t i = 0; i < index_.size(); ++i) is_ground_[i] = chosen[component_of_[i]];
}

/// Heights of the nearest ground, breadth first; what is out of reach gets the median.
void GroundField::fillGaps() {
  constexpr float kUnset = NAN;
  height_.assign(index_.size(), kUnset);
  std::vector<std::int32_t> queue;
  std::vector<float> known;
  for (std::size_t i = 0; i < index_.size(); ++i) {
    if (!is_ground_[i]) continue;
    height_[i] = lowest_[i];
    queue.push_back(static_cast<std::int32_t>(i));
    known.push_back(lowest_[i]);
  }
  if (known.empty()) return;
  const float typical = quantileOf(known, 0.5);
  for (std::size_t k = 0; k < queue.size(); ++k) {
    const CellIndex::Cell cell = index_.cells()[queue[k]];
    for (int dy = -kReach; dy <= kReach; ++dy) {
      for (int dx = -kReach; dx <= kReach; ++dx) {
        const std::int32_t j = index_.find(cell.x + dx, cell.y + dy);
        if (j < 0 || !std::isnan(height_[j])) continue;
        height_[j] = height_[queue[k]];
        queue.push_back(j);
      }
    }
  }
  std::replace_if(
      height_.begin(), height_.end(), [](float z) { return std::isnan(z); }, typical);
}

float GroundField::heightAt(float x, float y) const {
  const float fx = x / kCell_m - 0.5F, fy = y / kCell_m - 0.5F;
  const std::int32_t ix = floorToInt(fx), iy = floorToInt(fy);
  const float rx = fx - static_cast<float>(ix), ry = fy - static_cast<float>(iy);
  const std::int32_t own = cellAt(x, y);
  const float fallback = own < 0 ? 0 : height_[own];
  const auto at = [&](std::int32_t cx, std::int32_t cy) {
    const std::int32_t i = index_.find(cx, cy);
    return i < 0 ? fallback : height_[i];
  };
  return (at(ix, iy) * (1 - rx) + at(ix + 1, iy) * rx) * (1 - ry) +
         (at(ix, iy + 1) * (1 - rx) + at(ix + 1, iy + 1) * rx) * ry;
}

bool GroundField::isSeenAt(float x, float y) const {
  const std::int32_t i = cellAt(x, y);
  return i >= 0 && is_ground_[i];
}

}  // namespace xview::label
