// SPDX-License-Identifier: BSD-3-Clause
#include "xview/graph/merge_plan_views.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <unordered_set>

#include "xview/types/error.h"

namespace xview {
namespace {

constexpr float kSameObject_m = 1.0f;

std::uint64_t keyOf(std::int64_t x, std::int64_t y) {
  return (static_cast<std::uint64_t>(static_cast<std::uint32_t>(x)) << 32) |
         static_cast<std::uint32_t>(y);
}

std::int64_t cellOf(float p, double side) {
  return static_cast<std::int64_t>(std::floor(p / side));
}

using CellSet = std::unordered_set<std::uint64_t>;

void addKnown(PlanView& view, const std::vector<GroundCell>& addition, CellSet& measured_before) {
  std::unordered_map<std::uint64_t, std::size_t> index;
  for (std::size_t i = 0; i < view.known.size(); ++i) {
    index.emplace(keyOf(view.known[i].x, view.known[i].y), i);
    if (view.known[i].measured) measured_before.insert(keyOf(view.known[i].x, view.known[i].y));
  }
  for (const GroundCell& cell : addition) {
    const auto [it, is_new] = index.emplace(keyOf(cell.x, cell.y), view.known.size());
    if (is_new)
      view.known.push_back(cell);
    else if (cell.measured && !view.known[it->second].measured)
      view.known[it->second] = cell;
  }
  std::sort(view.known.begin(), view.known.end(), [](const GroundCell& a, const GroundCell& b) {
    return a.y != b.y ? a.y < b.y : a.x < b.x;
  });
}

bool isBorder(Channel c) {
  return c >= Channel::border_road_sidewalk && c <= Channel::border_road_terrain;
}

/// One sample per cell, the one that was there first; none in cells that are `taken`. Borders lie
/// on the edges of cells, so that two of them may meet in one cell, but not in one quarter of it.
void addSurface(Channel channel, PlanView& view, const std::vector<PlanSample>& addition,
                const CellSet* taken) {
  std::vector<PlanSample>& samples = view[channel];
  const double side = isBorder(channel) ? view.cell_m / 2 : view.cell_m;
  CellSet occupied;
  for (const PlanSample& s : samples) occupied.insert(keyOf(cellOf(s.x, side), cellOf(s.y, side)));
  for (const PlanSample& s : addition) {
    if (taken && taken->count(keyOf(cellOf(s.x, view.cell_m), cellOf(s.y, view.cell_m)))) continue;
    if (occupied.insert(keyOf(cellOf(s.x, side), cellOf(s.y, side))).second) samples.push_back(s);
  }
}

void addObjects(std::vector<PlanSample>& samples, const std::vector<PlanSample>& addition) {
  const std::size_t before = samples.size();
  std::unordered_map<std::uint64_t, std::vector<std::size_t>> index;
  for (std::size_t i = 0; i < before; ++i) {
    index[keyOf(cellOf(samples[i].x, kSameObject_m), cellOf(samples[i].y, kSameObject_m))]
        .push_back(i);
  }
  for (const PlanSample& s : addition) {
    bool known = false;
    for (int dy = -1; dy <= 1 && !known; ++dy) {
      for (int dx = -1; dx <= 1 && !known; ++dx) {
        const auto it =
            index.find(keyOf(cellOf(s.x, kSameObject_m) + dx, cellOf(s.y, kSameObject_m) + dy));
        if (it == index.end()) continue;
        known = std::any_of(it->second.begin(), it->second.end(), [&](std::size_t i) {
          return std::hypot(samples[i].x - s.x, samples[i].y - s.y) <= kSameObject_m;
        });
      }
    }
    if (!known) samples.push_back(s);
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
    throw UsageError("plan.cell_m of the map and of what is added to it differ");
  const PlanView moved = shifted(addition, view);
  CellSet measured_before;
  addKnown(view, moved.known, measured_before);
  for (std::size_t c = 0; c < kChannels; ++c) {
    const auto channel = static_cast<Channel>(c);
    const bool ground = isArea(channel) || isBorder(channel);
    if (isObject(channel))
      addObjects(view.samples[c], moved.samples[c]);
    else
      addSurface(channel, view, moved.samples[c], ground ? &measured_before : nullptr);
    std::sort(view.samples[c].begin(), view.samples[c].end(),
              [](const PlanSample& a, const PlanSample& b) {
                return a.y != b.y ? a.y < b.y : a.x < b.x;
              });
  }
}

}  // namespace xview
