// SPDX-License-Identifier: BSD-3-Clause
#include "place/ground_field.h"

#include <algorithm>
#include <cmath>

#include "base/median.h"

namespace xview {
namespace {

constexpr int kUnseenCells =
    3;  ///< cells over which ground runs on unseen, such as between two beams
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
  ground_.fillGaps(kUnseenCells);
}

void GroundField::findLowest(const pcl::PointCloud<Point>& points) {
  std::vector<std::int32_t> cell_of;
  cell_of.reserve(points.size());
  for (const Point& p : points)
    cell_of.push_back(
        ground_.index.findOrAdd(floorToInt(p.x / kCell_m), floorToInt(p.y / kCell_m)));
  const Grouped groups(cell_of, ground_.index.size());
  std::vector<float> heights;
  for (std::size_t c = 0; c < ground_.index.size(); ++c) {
    float sigmas = 0;
    heights.clear();
    for (std::size_t k = groups.starts[c]; k < groups.starts[c + 1]; ++k) {
      heights.push_back(points[groups.order[k]].z);
      sigmas += points[groups.order[k]].sigma;
    }
    lowest_.push_back(rankedOf(heights, std::min(kSpurious, (heights.size() - 1) / 3)));
    sigma_.push_back(sigmas / static_cast<float>(heights.size()));
  }
}

float GroundField::toleranceOf(std::size_t cell, std::size_t other, float distance_m) const {
  return kRough_m + kSlope * distance_m + 2 * std::hypot(sigma_[cell], sigma_[other]);
}

void GroundField::joinCells() {
  const std::vector<Offset> offsets = halfRing(kUnseenCells);
  DisjointSets sets(ground_.index.size());
  for (std::size_t i = 0; i < ground_.index.size(); ++i) {
    const PlaneCell cell = ground_.index.cells()[i];
    for (const Offset& o : offsets) {
      const std::int32_t j = ground_.index.find(cell.x + o.x, cell.y + o.y);
      if (j < 0 || std::abs(lowest_[i] - lowest_[j]) >= toleranceOf(i, j, o.distance_m)) continue;
      sets.unite(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j));
    }
  }
  for (std::uint32_t i = 0; i < ground_.index.size(); ++i) component_of_.push_back(sets.find(i));
}

void GroundField::chooseGround() {
  const std::vector<Offset> offsets = halfRing(kUnseenCells);
  std::vector<Patch> patches(ground_.index.size());
  for (std::size_t i = 0; i < ground_.index.size(); ++i) {
    Patch& patch = patches[component_of_[i]];
    ++patch.cells;
    patch.lowest = std::min(patch.lowest, lowest_[i]);
    const PlaneCell cell = ground_.index.cells()[i];
    for (const Offset& o : offsets) {
      const std::int32_t j = ground_.index.find(cell.x + o.x, cell.y + o.y);
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
  is_ground_.resize(ground_.index.size());
  ground_.heights.resize(ground_.index.size());
  for (std::size_t i = 0; i < ground_.index.size(); ++i) {
    is_ground_[i] = chosen[component_of_[i]];
    ground_.heights[i] = is_ground_[i] ? lowest_[i] : NAN;
  }
}

bool GroundField::isSeenAt(float x, float y) const {
  const std::int32_t i = ground_.cellAt(x, y);
  return i >= 0 && is_ground_[i];
}

}  // namespace xview
