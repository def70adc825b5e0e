// SPDX-License-Identifier: BSD-3-Clause
#include "graph/plan_floor.h"

#include <algorithm>
#include <array>

namespace xview {
namespace {

using FloorClass = std::int8_t;  ///< one of kRoad, kSidewalk, kTerrain, kNoFloor
constexpr FloorClass kNoFloor = -1, kRoad = 0, kSidewalk = 1;
constexpr std::array<Channel, 3> kAreas = {Channel::road, Channel::sidewalk, Channel::terrain};
constexpr float kMarkingShare = 0.4f;  ///< of the ground votes of a cell that is a lane marking

/// The majority ground class of a cell; lane markings count as road.
FloorClass floorClass(const FloorCell& cell, const PlanOptions& options) {
  const std::array<float, 3> votes = {cell.votes[0] + cell.votes[3], cell.votes[1], cell.votes[2]};
  const auto best = std::max_element(votes.begin(), votes.end());
  const bool clear =
      *best > 0 && cell.ground() >= options.min_votes && *best >= options.min_share * cell.ground();
  return clear ? static_cast<FloorClass>(best - votes.begin()) : kNoFloor;
}

/// The majority of the 3x3 neighbourhood of a cell with a class: labels of a network flicker at the
/// scale of a cell.
FloorClass majorityAround(const PlanCells& cells, const std::vector<FloorClass>& classes,
                          std::size_t i) {
  if (classes[i] == kNoFloor) return kNoFloor;
  std::array<int, 3> count{};
  const CellIndex::Cell c = cells.index.cells()[i];
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const std::int32_t j = cells.index.find(c.x + dx, c.y + dy);
      if (j >= 0 && classes[j] != kNoFloor) ++count[classes[j]];
    }
  }
  const auto best = std::max_element(count.begin(), count.end());
  return *best > count[classes[i]] ? static_cast<FloorClass>(best - count.begin()) : classes[i];
}

std::vector<FloorClass> floorClasses(const PlanCells& cells, const PlanOptions& options) {
  std::vector<FloorClass> raw, filtered;
  for (const FloorCell& cell : cells.floor) raw.push_back(floorClass(cell, options));
  for (std::size_t i = 0; i < raw.size(); ++i) filtered.push_back(majorityAround(cells, raw, i));
  return filtered;
}

Channel borderChannel(FloorClass a, FloorClass b) {
  const auto [low, high] = std::minmax(a, b);
  if (low == kSidewalk) return Channel::border_sidewalk_terrain;
  return high == kSidewalk ? Channel::border_road_sidewalk : Channel::border_road_terrain;
}

}  // namespace

void addFloor(const PlanCells& cells, const PlanOptions& options, PlanView& view) {
  const std::vector<FloorClass> classes = floorClasses(cells, options);
  const auto side = static_cast<float>(options.cell_m);
  for (std::size_t i = 0; i < classes.size(); ++i) {
    if (classes[i] == kNoFloor) continue;
    const FloorCell& cell = cells.floor[i];
    const CellIndex::Cell c = cells.index.cells()[i];
    const float x = (static_cast<float>(c.x) + 0.5f) * side,
                y = (static_cast<float>(c.y) + 0.5f) * side;
    view[kAreas[classes[i]]].push_back({x, y, cell.height});
    if (cell.votes[3] > kMarkingShare * cell.ground())
      view[Channel::lane_marking].push_back({x, y, cell.height});
    const auto addBorder = [&](std::int32_t j, float border_x, float border_y) {
      if (j < 0 || classes[j] == kNoFloor || classes[j] == classes[i]) return;
      view[borderChannel(classes[i], classes[j])].push_back({border_x, border_y, cell.height});
    };
    addBorder(cells.index.find(c.x + 1, c.y), x + side / 2, y);
    addBorder(cells.index.find(c.x, c.y + 1), x, y + side / 2);
  }
}

}  // namespace xview
