// SPDX-License-Identifier: BSD-3-Clause
#include "graph/post_feet.h"

#include <algorithm>

namespace xview {
namespace {

constexpr int kArmReach = 5;        ///< cells: arms of street lamps are up to 2.5 m long
constexpr float kHangs = 0.1f;      ///< share of the votes near the ground, at most
constexpr int kTaller = 2;          ///< times as high as what hangs is a post
constexpr int kFewestLevels = 3;    ///< that a post has and what hangs from it has not
constexpr float kLampBottom_m = 4;  ///< lamps on short arms hang higher than noise of posts starts
constexpr float kLampShare = 0.3f;  ///< of the votes of a peak that pulls its centre off

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

bool isFarTaller(const Part& post, const Part& lamp) {
  return post.height() >= std::max(kTaller * lamp.height(), lamp.height() + kFewestLevels);
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
CellIndex::Cell tallestAround(const PlanCells& cells, CellIndex::Cell c, int reach) {
  CellIndex::Cell tallest = c;
  Part best = partAt(cells, c);
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
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

/// Whether a good part of the votes around a cell hang beside the post there: the lamp of a short
/// arm, which has one peak with its post.
bool hasLamp(const PlanCells& cells, CellIndex::Cell c, const Part& post) {
  float all = 0, hanging = 0;
  cells.forUprightAround(c, 1, [&](const UprightCell& cell, CellIndex::Cell where) {
    const Standing* pole = cell.find(Kind::pole);
    if (!pole) return;
    all += pole->votes;
    if (pole->bottom >= kLampBottom_m && isFarTaller(post, partAt(cells, where)))
      hanging += pole->votes;
  });
  return hanging > kLampShare * all;
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
  const bool hangs = isHangingPole(cells, peak);
  const CellIndex::Cell foot = tallestAround(cells, peak, hangs ? kArmReach : 1);
  const Part post = partAt(cells, foot);
  const bool is_off = hangs ? isFarTaller(post, partAt(cells, peak)) : hasLamp(cells, peak, post);
  if (!is_off) return std::nullopt;
  return centreOfPost(cells, foot);
}

}  // namespace xview
