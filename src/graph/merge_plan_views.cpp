// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <string>

#include "xview/graph/plan_view.h"
#include "xview/types/cells.h"
#include "xview/types/error.h"

namespace xview::graph {
namespace {

constexpr float kSameObject_m = 1.0f;

/// Returns the cells that `view` had measured before.
CellIndex addKnown(PlanView& view, const std::vector<GroundCell>& addition) {
  CellIndex index, measured_before;  // the numbers of `index` are positions in view.known
  for (const GroundCell& cell : view.known) {
    index.findOrAdd(cell.x, cell.y);
    if (cell.measured) measured_before.findOrAdd(cell.x, cell.y);
  }
  for (const GroundCell& cell : addition) {
    const auto at = static_cast<std::size_t>(index.findOrAdd(cell.x, cell.y));
    if (at == view.known.size())
      view.known.push_back(cell);
    else if (cell.measured && !view.known[at].measured)
      view.known[at] = cell;
  }
  std::sort(view.known.begin(), view.known.end(), inRowOrder<GroundCell>);
  return measured_before;
}

bool isBorder(Channel c) {
  return c >= Channel::border_road_sidewalk && c <= Channel::border_road_terrain;
}

CellIndex::Cell planCellOf(const PlanSample& s, double side) {
  return {floorToInt(s.x / side), floorToInt(s.y / side)};
}

/// One sample per cell, the one that was there first; none in cells that are `taken`. Borders lie
/// on the edges of cells, so that two of them may meet in one cell, but not in one quarter of it.
void addSurface(Channel channel, PlanView& view, const std::vector<PlanSample>& addition,
                const CellIndex* taken) {
  std::vector<PlanSample>& samples = view[channel];
  const double side = isBorder(channel) ? view.cell_m / 2 : view.cell_m;
  CellIndex occupied;
  const auto occupy = [&](const PlanSample& s) {
    const CellIndex::Cell c = planCellOf(s, side);
    const std::size_t before = occupied.size();
    occupied.findOrAdd(c.x, c.y);
    return occupied.size() > before;
  };
  for (const PlanSample& s : samples) occupy(s);
  for (const PlanSample& s : addition) {
    const CellIndex::Cell c = planCellOf(s, view.cell_m);
    if (taken && taken->find(c.x, c.y) >= 0) continue;
    if (occupy(s)) samples.push_back(s);
  }
}

void addObjects(std::vector<PlanSample>& samples, const std::vector<PlanSample>& addition) {
  const auto cellOfObject = [](const PlanSample& s) {
    return cellOf(Eigen::Vector3d(s.x, s.y, 0), kSameObject_m, 0);
  };
  CellLists known;
  for (std::size_t i = 0; i < samples.size(); ++i) known.add(cellOfObject(samples[i]), i);
  for (const PlanSample& s : addition) {
    bool is_known = false;
    known.forAround(cellOfObject(s), [&](std::size_t i) {
      is_known |= std::hypot(samples[i].x - s.x, samples[i].y - s.y) <= kSameObject_m;
    });
    if (!is_known) samples.push_back(s);
  }
}

/// The addition in the coordinates of the view; origins differ by whole cells.
PlanView shifted(const PlanView& addition, const PlanView& view) {
  PlanView result = addition;
  const auto dx = static_cast<float>(addition.origin_x - view.origin_x),
             dy = static_cast<float>(addition.origin_y - view.origin_y),
             dz = static_cast<float>(addition.origin_z - view.origin_z);
  for (auto& channel : result.samples) {
    for (PlanSample& s : channel) s = {s.x + dx, s.y + dy, s.z + dz};
  }
  const auto cx = static_cast<std::int32_t>(std::lround(dx / view.cell_m)),
             cy = static_cast<std::int32_t>(std::lround(dy / view.cell_m));
  for (GroundCell& cell : result.known) {
    cell.x += cx;
    cell.y += cy;
    cell.z += dz;
  }
  return result;
}

}  // namespace

void mergePlanViews(PlanView& view, const PlanView& addition) {
  if (addition.known.empty()) return;
  if (view.known.empty()) {
    view = addition;
    return;
  }
  if (view.cell_m != addition.cell_m)
    throw UsageError("the views from above of the map and of what is added to it have cells of " +
                     std::to_string(view.cell_m) + " and " + std::to_string(addition.cell_m) +
                     " m; they cannot be joined");
  const PlanView moved = shifted(addition, view);
  const CellIndex measured_before = addKnown(view, moved.known);
  for (std::size_t c = 0; c < kChannels; ++c) {
    const auto channel = static_cast<Channel>(c);
    const bool is_ground = isArea(channel) || isBorder(channel);
    if (isObject(channel))
      addObjects(view.samples[c], moved.samples[c]);
    else
      addSurface(channel, view, moved.samples[c], is_ground ? &measured_before : nullptr);
    std::sort(view.samples[c].begin(), view.samples[c].end(), inRowOrder<PlanSample>);
  }
}

}  // namespace xview::graph
