// SPDX-License-Identifier: BSD-3-Clause
#include "graph/plan_columns.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "graph/value_grid.h"

namespace xview {
namespace {

constexpr int kCore = 1, kRing = 3;  ///< half sizes in cells: of the column, and of what is free
constexpr float kClutter = 0.3f;     ///< votes around a column, as a share of its own
constexpr float kWidestSpread_m = 0.3f;  ///< a bush has more
constexpr float kClearShare = 0.85f;     ///< of one label

/// Votes around a cell with their moments, relative to their mean in the cell itself.
struct Moments {
  float votes = 0, x = 0, y = 0, square = 0;
  float spread() const {
    const float mean_x = x / votes, mean_y = y / votes;
    return std::sqrt(std::max(0.f, square / votes - mean_x * mean_x - mean_y * mean_y));
  }
};

Moments momentsAround(const PlanCells& cells, CellIndex::Cell c, const Column& own) {
  Moments m;
  const float x0 = own.x / own.votes(), y0 = own.y / own.votes();
  cells.forUprightAround(c, kCore, [&](const UprightCell& cell, CellIndex::Cell) {
    const float w = cell.column.votes();
    if (w <= 0) return;
    const float x = cell.column.x / w - x0, y = cell.column.y / w - y0;
    m.votes += w;
    m.x += w * x;
    m.y += w * y;
    m.square += w * (x * x + y * y);
  });
  return m;
}

bool standsAlone(const ValueGrid& band, CellIndex::Cell cell, float min_votes) {
  const float core = band.sumAround(cell, kCore);
  return core >= min_votes && band.sumAround(cell, kRing) <= (1 + kClutter) * core;
}

/// True if nearly all labels agree on what a column is.
bool isLabelledClearly(const PlanCells& cells, CellIndex::Cell cell) {
  std::array<float, static_cast<std::size_t>(Kind::none)> votes{};
  float total = 0;
  cells.forUprightAround(cell, kCore, [&](const UprightCell& c, CellIndex::Cell) {
    for (const Standing* s = c.first; s != c.last; ++s) {
      const Kind kind = s->kind == Kind::trunk ? Kind::vegetation : s->kind;  // both are trees
      votes[static_cast<std::size_t>(kind)] += s->near_votes;
      total += s->near_votes;
    }
  });
  return *std::max_element(votes.begin(), votes.end()) > kClearShare * total;
}

}  // namespace

std::vector<PlanSample> findColumns(const PlanCells& cells, double min_votes) {
  const auto fewest = static_cast<float>(min_votes);
  const ValueGrid low(cells, [](const UprightCell& c) { return c.column.low; });
  const ValueGrid high(cells, [](const UprightCell& c) { return c.column.high; });
  const ValueGrid all(cells, [](const UprightCell& c) { return c.column.votes(); });
  const ValueGrid sums = all.boxSum(kCore);
  std::vector<PlanSample> found;
  for (std::size_t i = 0; i < cells.index.size(); ++i) {
    if (sums[i] <= 0 || sums[i] < 2 * fewest || !sums.isMaximum(i, kRing)) continue;
    const CellIndex::Cell cell = cells.index.cells()[i];
    if (!standsAlone(low, cell, fewest) || !standsAlone(high, cell, fewest)) continue;
    const Column& own = cells.uprightOf(i)->column;
    const Moments m = momentsAround(cells, cell, own);
    if (m.spread() > kWidestSpread_m || isLabelledClearly(cells, cell)) continue;
    found.push_back({own.x / own.votes() + m.x / m.votes, own.y / own.votes() + m.y / m.votes,
                     cells.floor[i].height});
  }
  return found;
}

}  // namespace xview
