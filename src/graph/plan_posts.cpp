// SPDX-License-Identifier: BSD-3-Clause
#include "graph/plan_cells.h"

namespace xview::graph {
namespace {

constexpr float kPeakVotes = 2;         ///< that make a pole, sign or light
constexpr int kPeakReach = 3;           ///< a peak is the largest within so many cells
constexpr float kMinPoleShare = 0.25f;  ///< of the votes of the other upright classes in the cell

/// Weighted mean of the pole-like points in the 3x3 cells around a peak.
PlanSample peakCentre(const PlanCells& cells, const ValueGrid& value, CellIndex::Cell c) {
  float weight = 0, x = 0, y = 0;
  cells.forUprightAround(c, 1, [&](const UprightCell& cell, CellIndex::Cell where) {
    const float w = value.at(where);
    if (w <= 0) return;
    float votes = 0, sum_x = 0, sum_y = 0;
    for (const Standing* s = cell.first; s != cell.last; ++s) {
      if (!isPoleLike(s->kind)) continue;
      votes += s->votes;
      sum_x += s->sum_x;
      sum_y += s->sum_y;
    }
    if (votes <= 0) return;
    weight += w;
    x += w * sum_x / votes;
    y += w * sum_y / votes;
  });
  if (weight <= 0) return {};
  return {x / weight, y / weight, cells.floor[cells.index.find(c.x, c.y)].height};
}

/// Peaks of the votes of some kinds, where nothing else has many more.
std::vector<PlanSample> peaksOf(const std::vector<Kind>& kinds, const PlanCells& cells) {
  const ValueGrid value(cells, [&](const UprightCell& cell) {
    float votes = 0;
    for (const Kind kind : kinds) votes += cell.of(kind).near_votes;
    return votes >= kMinPoleShare * cell.ofThingsBesidePosts() ? votes : 0.f;
  });
  const ValueGrid sums = value.boxSum(1);
  std::vector<PlanSample> peaks;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (sums[i] >= kPeakVotes && sums.isMaximum(i, kPeakReach))
      peaks.push_back(peakCentre(cells, value, cells.cell(i)));
  }
  return peaks;
}

}  // namespace

void findPosts(const PlanCells& cells, PlanView& view) {
  view[Channel::pole] = peaksOf({Kind::pole}, cells);
  view[Channel::sign] = peaksOf({Kind::sign}, cells);
  view[Channel::light] = peaksOf({Kind::light}, cells);
  view[Channel::pole_like] = peaksOf({Kind::pole, Kind::sign, Kind::light}, cells);
}

}  // namespace xview::graph
