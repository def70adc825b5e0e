// SPDX-License-Identifier: BSD-3-Clause
#include "graph/plan_posts.h"

#include <algorithm>
#include <cmath>

#include "graph/plan_columns.h"
#include "graph/post_feet.h"
#include "graph/value_grid.h"

namespace xview {
namespace {

constexpr int kPeakReach = 3;           ///< a peak is the largest within so many cells
constexpr float kMinPoleShare = 0.25f;  ///< of the votes of the other upright classes in the cell
/// A post may stand before a wall, so that less than that share is its own. Then the places where
/// it outvotes the wall speak for it, with half their votes, because walls have wrong labels here
/// and there.
constexpr float kBeforeWall = 0.5f;
/// So many times the votes of a peak are believed beside anything; fewer only if no more speaks for
/// something else, because networks find poles in walls and trunks here and there. From the air
/// posts have few votes, and crowns stand beside all of them.
constexpr float kSure = 2;
constexpr float kSameFoot_m = 1, kSameColumn_m = 1.5f;  ///< as a post that is known already

/// Weighted mean of the pole-like points in the 3x3 cells around a peak.
PlanSample peakCentre(const PlanCells& cells, const ValueGrid& value, CellIndex::Cell c) {
  float weight = 0, x = 0, y = 0;
  cells.forUprightAround(c, 1, [&](const UprightCell& cell, CellIndex::Cell where) {
    const float w = value.at(where.x, where.y);
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

/// Greatest height of anything pole-like in the 3x3 cells around one.
float poleTop(const PlanCells& cells, CellIndex::Cell c) {
  float top = 0;
  cells.forUprightAround(c, 1, [&](const UprightCell& cell, CellIndex::Cell) {
    for (const Standing* s = cell.first; s != cell.last; ++s) {
      if (isPoleLike(s->kind)) top = std::max(top, s->top);
    }
  });
  return top;
}

/// Networks take people and bins for poles. Such a thing was seen well, in part by another label,
/// and ends at about 2 m although the sensor saw higher ones beside it.
class LowThings {
 public:
  LowThings(const PlanCells& cells, double min_votes)
      : cells_(cells),
        low_(cells, [](const UprightCell& c) { return c.column.low; }),
        high_(cells, [](const UprightCell& c) { return c.column.high; }),
        min_votes_(static_cast<float>(min_votes)) {}

  bool contain(CellIndex::Cell cell, float peak_votes) const {
    constexpr float kSeenWell = 25, kOtherLabels = 0.8f, kHigher = 0.02f, kBeside = 0.5f;
    constexpr float kTop_m = 2.2f;
    constexpr int kBesideReach = 9;  // cells
    const float low = low_.sumAround(cell, 1);
    return low >= kSeenWell * min_votes_ && peak_votes < kOtherLabels * low &&
           high_.sumAround(cell, 1) < kHigher * low &&
           high_.sumAround(cell, kBesideReach) > kBeside * low && poleTop(cells_, cell) < kTop_m;
  }

 private:
  const PlanCells& cells_;
  ValueGrid low_, high_;
  float min_votes_;
};

/// Adds those that are not there yet.
void addUnknown(const std::vector<PlanSample>& more, float same_m,
                std::vector<PlanSample>& samples) {
  for (const PlanSample& s : more) {
    const bool is_known = std::any_of(samples.begin(), samples.end(), [&](const PlanSample& p) {
      return std::hypot(p.x - s.x, p.y - s.y) < same_m;
    });
    if (!is_known) samples.push_back(s);
  }
}

/// Peaks of the votes of pole-like things.
class PeakFinder {
 public:
  PeakFinder(const PlanCells& cells, const PlanOptions& options, bool aerial)
      : cells_(cells),
        low_things_(cells, options.min_votes),
        min_votes_(static_cast<float>(options.peak_votes * options.min_votes)),
        aerial_(aerial) {}

  std::vector<PlanSample> find(const std::vector<Kind>& kinds) const {
    const ValueGrid value(cells_, [&](const UprightCell& cell) {
      float votes = 0, own = 0;
      for (const Kind kind : kinds) {
        votes += cell.nearOf(kind);
        own += cell.ownOf(kind);
      }
      return votes >= kMinPoleShare * cell.ofThingsBesidePosts() ? votes : kBeforeWall * own;
    });
    const ValueGrid sums = value.boxSum(1);
    const bool of_poles = std::count(kinds.begin(), kinds.end(), Kind::pole) > 0;
    std::vector<PlanSample> peaks, feet;
    for (std::size_t i = 0; i < cells_.index.size(); ++i) {
      if (sums[i] <= 0 || sums[i] < min_votes_) continue;
      const CellIndex::Cell cell = cells_.index.cells()[i];
      const bool is_peak = sums.isMaximum(i, kPeakReach) ||
                           (sums.isMaximum(i, kPeakReach - 1) && standsApart(kinds, value, cell));
      if (!is_peak || low_things_.contain(cell, sums[i])) continue;
      if (!of_poles && !isClear(kinds, cell)) continue;
      if (!aerial_ && sums[i] < kSure * min_votes_ && hasRivals(kinds, cell)) continue;
      const auto foot = of_poles ? findFoot(cells_, cell) : std::nullopt;
      if (foot)
        feet.push_back(*foot);
      else
        peaks.push_back(peakCentre(cells_, value, cell));
    }
    addUnknown(feet, kSameFoot_m, peaks);
    return peaks;
  }

 private:
  /// A post of its own, though there is a greater one not far away: bollards in a row. What belongs
  /// to that one, its lamp or its smear, leaves no gap, or does not stand on the ground as well.
  bool standsApart(const std::vector<Kind>& kinds, const ValueGrid& value,
                   CellIndex::Cell c) const {
    constexpr float kInTheGap = 0.1f, kLowShare = 0.25f;
    const float own = value.sumAround(c, 1);
    if (value.sumAround(c, 2) > (1 + kInTheGap) * own) return false;
    float low = 0;
    cells_.forUprightAround(c, 1, [&](const UprightCell& cell, CellIndex::Cell where) {
      if (value.at(where.x, where.y) <= 0) return;
      for (const Kind kind : kinds) low += cell.lowOf(kind);
    });
    return low >= kLowShare * own;
  }

  /// Posts are called signs and lights here and there; what is one is not called a pole as well.
  bool isClear(const std::vector<Kind>& kinds, CellIndex::Cell c) const {
    constexpr float kClearShare = 0.5f;
    float all = 0, clear = 0;
    cells_.forUprightAround(c, 1, [&](const UprightCell& cell, CellIndex::Cell) {
      for (const Kind kind : kinds) {
        all += cell.nearOf(kind);
        clear += cell.clearOf(kind);
      }
    });
    return clear >= kClearShare * all;
  }

  /// Whether anything else stands there with as many votes, in the very places of the post.
  bool hasRivals(const std::vector<Kind>& kinds, CellIndex::Cell c) const {
    constexpr float kOwnShare = 0.75f;
    float all = 0, own = 0, others = 0;
    cells_.forUprightAround(c, 1, [&](const UprightCell& cell, CellIndex::Cell) {
      for (const Kind kind : kinds) {
        all += cell.nearOf(kind);
        own += cell.ownOf(kind);
      }
      others += cell.ofThingsBesidePosts();
    });
    return others > all && own < kOwnShare * all;
  }

  const PlanCells& cells_;
  LowThings low_things_;
  float min_votes_;
  bool aerial_;
};

}  // namespace

void findPosts(const PlanCells& cells, const PlanOptions& options, PlanView& view) {
  constexpr double kColumnVotes = 20;  // of min_votes, at each height
  const PeakFinder peaks(cells, options, view.aerial);
  view[Channel::pole] = peaks.find({Kind::pole});
  view[Channel::sign] = peaks.find({Kind::sign});
  view[Channel::light] = peaks.find({Kind::light});
  view[Channel::pole_like] = peaks.find({Kind::pole, Kind::sign, Kind::light});
  addUnknown(findColumns(cells, kColumnVotes * options.min_votes), kSameColumn_m,
             view[Channel::pole_like]);
}

}  // namespace xview
