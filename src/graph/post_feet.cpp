// SPDX-License-Identifier: BSD-3-Clause
#include "graph/post_feet.h"

#include <algorithm>

namespace xview {
namespace {

constexpr int kArmReach = 5;      ///< cells: arms of street lamps are up to 2.5 m long
constexpr float kHangs = 0.1f;    ///< share of the votes near the ground, at most
constexpr int kTaller = 2;        ///< times as high as what hangs is a post
constexpr int kFewestLevels = 3;  ///< that a post has and what hangs from it has not

/// What a cell has of a post.
struct Part {
  float votes = 0, x = 0, y = 0;
  std::uint32_t levels = 0;
  int height() const { return __builtin_popcount(levels); }
};

Part partAt(const PlanCells& cells, CellIndex::Cell c) {
  Part part;
  const UprightCell* cell = cells.uprightAt(c.x, c.y);
  if (!cell) return part;
  if (const Standing* s = cell->find(Kind::pole)) {
    part.votes = s->votes;
    part.x = s->sum_x;
    part.y = s->sum_y;
    part.levels = s->levels;
  }
  const Strays& strays = cell->strays;
  if (strays.votes <= cell->ofThingsBesidePosts()) return part;
  part.votes += strays.votes;
  part.x += strays.x;
  part.y += strays.y;
  part.levels |= strays.levels;
  return part;
}

bool isHangingPole(const PlanCells& cells, CellIndex::Cell c) {
  float all = 0, low = 0, poles = 0;
  cells.forUprightAround(c, 1, [&](const UprightCell& cell, CellIndex::Cell) {
    for (const Kind kind : {Kind::pole, Kind::sign, Kind::light}) {
      all += cell.of(kind);
      low += cell.lowOf(kind);
    }
    poles += cell.of(Kind::pole);
  });
  return low <= kHangs * all && 2 * poles >= all;
}

/// The cell around one that has something at most heights, of equal ones the one with most votes.
CellIndex::Cell tallestAround(const PlanCells& cells, CellIndex::Cell c) {
  CellIndex::Cell tallest = c;
  Part best = partAt(cells, c);
  for (int dy = -kArmReach; dy <= kArmReach; ++dy) {
    for (int dx = -kArmReach; dx <= kArmReach; ++dx) {
      const Part part = partAt(cells, {c.x + dx, c.y + dy});
      const bool more_votes = part.votes > best.votes;
      if (part.height() < best.height() || (part.height() == best.height() && !more_votes))
        continue;
      tallest = {c.x + dx, c.y + dy};
      best = part;
    }
  }
  return tallest;
}

/// Mean of the 3x3 cells around a foot that are half as tall, as the post may stand between cells.
PlanSample centreOfPost(const PlanCells& cells, CellIndex::Cell foot) {
  const int tallest = partAt(cells, foot).height();
  Part post;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const Part part = partAt(cells, {foot.x + dx, foot.y + dy});
      if (2 * part.height() < tallest) continue;
      post.votes += part.votes;
      post.x += part.x;
      post.y += part.y;
    }
  }
  return {post.x / post.votes, post.y / post.votes,
          cells.floor[cells.index.find(foot.x, foot.y)].height};
}

}  // namespace

std::optional<PlanSample> findFoot(const PlanCells& cells, CellIndex::Cell peak) {
  if (!isHangingPole(cells, peak)) return std::nullopt;
  const int own = partAt(cells, peak).height();
  const CellIndex::Cell foot = tallestAround(cells, peak);
  if (partAt(cells, foot).height() < std::max(kTaller * own, own + kFewestLevels))
    return std::nullopt;
  return centreOfPost(cells, foot);
}

}  // namespace xview
