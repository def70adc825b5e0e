// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "graph/plan_cells.h"

namespace xview::graph {
namespace {

constexpr int kCore = 1, kRing = 3;  ///< half sizes in cells: of the column, and of what is free
constexpr float kColumnVotes = 20;   ///< of a column, below and above 2 m
constexpr float kClutter = 0.3f;     ///< votes around a column, as a share of its own
constexpr float kWidestSpread_m = 0.3f;  ///< a bush has more
constexpr float kLabelledShare = 0.85f;  ///< of one label, which is believed then

/// Votes around a cell with their moments, relative to their mean in the cell itself.
struct VoteMoments {
  float votes = 0, x = 0, y = 0, square = 0;
  float spread() const {
    const float mean_x = x / votes, mean_y = y / votes;
    return std::sqrt(std::max(0.f, square / votes - mean_x * mean_x - mean_y * mean_y));
  }
};

VoteMoments momentsAround(const PlanCells& cells, CellIndex::Cell c, const Column& own) {
  VoteMoments m;
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

bool standsAlone(const ValueGrid& band, CellIndex::Cell cell) {
  const float core = band.sumAround(cell, kCore);
  return core >= kColumnVotes && band.sumAround(cell, kRing) <= (1 + kClutter) * core;
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
  return *std::max_element(votes.begin(), votes.end()) > kLabelledShare * total;
}

/// Thin upright things of any label: a network may call a lamp post vegetation in all frames of a
/// drive and a pole in the next one, but it stands alone and is taller than it is wide. Each needs
/// votes below and above 2 m, and next to nothing within 1.5 m of it at either height. Where
/// nearly all labels agree they are believed: then it is a trunk, or whatever they say.
std::vector<PlanSample> findColumns(const PlanCells& cells) {
  const ValueGrid low(cells, [](const UprightCell& c) { return c.column.low; });
  const ValueGrid high(cells, [](const UprightCell& c) { return c.column.high; });
  const ValueGrid all(cells, [](const UprightCell& c) { return c.column.votes(); });
  const ValueGrid sums = all.boxSum(kCore);
  std::vector<PlanSample> found;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (sums[i] <= 0 || sums[i] < 2 * kColumnVotes || !sums.isMaximum(i, kRing)) continue;
    const CellIndex::Cell cell = cells.cell(i);
    if (!standsAlone(low, cell) || !standsAlone(high, cell)) continue;
    const Column& own = cells.uprightOf(i)->column;
    const VoteMoments m = momentsAround(cells, cell, own);
    if (m.spread() > kWidestSpread_m || isLabelledClearly(cells, cell)) continue;
    found.push_back({own.x / own.votes() + m.x / m.votes, own.y / own.votes() + m.y / m.votes,
                     cells.floor[i].height});
  }
  return found;
}

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
  const UprightCell* cell = cells.uprightAt(c);
  if (!cell) return part;
  const Standing& pole = cell->of(Kind::pole);
  part = {pole.votes, pole.sum_x, pole.sum_y, pole.levels};
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
      all += cell.of(kind).votes;
      low += cell.of(kind).low;
    }
    poles += cell.of(Kind::pole).votes;
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
    const Standing& pole = cell.of(Kind::pole);
    all += pole.votes;
    if (pole.bottom >= kLampBottom_m && isFarTaller(post, partAt(cells, where)))
      hanging += pole.votes;
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

/// The foot of a pole that hangs in the air around a cell, of a lamp on an arm: from above it hides
/// its post and has most of the votes, but the post is there at more heights. On a short arm both
/// are in one peak, and its middle between them. Nothing if the peak stands on the ground itself
/// without such a lamp, is a sign or a light, or if no post is within 2.5 m. A post may be too thin
/// for the labels, so that it has those of the ground behind it (Strays).
std::optional<PlanSample> findFoot(const PlanCells& cells, CellIndex::Cell peak) {
  const bool hangs = isHangingPole(cells, peak);
  const CellIndex::Cell foot = tallestAround(cells, peak, hangs ? kArmReach : 1);
  const Part post = partAt(cells, foot);
  const bool is_off = hangs ? isFarTaller(post, partAt(cells, peak)) : hasLamp(cells, peak, post);
  if (!is_off) return std::nullopt;
  return centreOfPost(cells, foot);
}

constexpr float kPeakVotes = 2;         ///< that make a pole, sign or light
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
  explicit LowThings(const PlanCells& cells)
      : cells_(cells),
        low_(cells, [](const UprightCell& c) { return c.column.low; }),
        high_(cells, [](const UprightCell& c) { return c.column.high; }) {}

  bool contain(CellIndex::Cell cell, float peak_votes) const {
    constexpr float kSeenWell = 25, kOtherLabels = 0.8f, kHigher = 0.02f, kBeside = 0.5f;
    constexpr float kTop_m = 2.2f;
    constexpr int kBesideReach = 9;  // cells
    const float low = low_.sumAround(cell, 1);
    return low >= kSeenWell * kMinVotes && peak_votes < kOtherLabels * low &&
           high_.sumAround(cell, 1) < kHigher * low &&
           high_.sumAround(cell, kBesideReach) > kBeside * low && poleTop(cells_, cell) < kTop_m;
  }

 private:
  const PlanCells& cells_;
  ValueGrid low_, high_;
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
  PeakFinder(const PlanCells& cells, bool aerial)
      : cells_(cells), low_things_(cells), aerial_(aerial) {}

  std::vector<PlanSample> find(const std::vector<Kind>& kinds) const {
    const ValueGrid value(cells_, [&](const UprightCell& cell) {
      float votes = 0, own = 0;
      for (const Kind kind : kinds) {
        votes += cell.of(kind).near_votes;
        own += cell.of(kind).own_votes;
      }
      return votes >= kMinPoleShare * cell.ofThingsBesidePosts() ? votes : kBeforeWall * own;
    });
    const ValueGrid sums = value.boxSum(1);
    const bool of_poles = std::count(kinds.begin(), kinds.end(), Kind::pole) > 0;
    std::vector<PlanSample> peaks, feet;
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      if (sums[i] <= 0 || sums[i] < kPeakVotes) continue;
      const CellIndex::Cell cell = cells_.cell(i);
      const bool is_peak = sums.isMaximum(i, kPeakReach) ||
                           (sums.isMaximum(i, kPeakReach - 1) && standsApart(kinds, value, cell));
      if (!is_peak || low_things_.contain(cell, sums[i])) continue;
      if (!of_poles && !isClear(kinds, cell)) continue;
      if (!aerial_ && sums[i] < kSure * kPeakVotes && hasRivals(kinds, cell)) continue;
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
      if (value.at(where) <= 0) return;
      for (const Kind kind : kinds) low += cell.of(kind).low;
    });
    return low >= kLowShare * own;
  }

  /// Posts are called signs and lights here and there; what is one is not called a pole as well.
  bool isClear(const std::vector<Kind>& kinds, CellIndex::Cell c) const {
    constexpr float kClearShare = 0.5f;
    float all = 0, clear = 0;
    cells_.forUprightAround(c, 1, [&](const UprightCell& cell, CellIndex::Cell) {
      for (const Kind kind : kinds) {
        all += cell.of(kind).near_votes;
        clear += cell.of(kind).clear_votes;
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
        all += cell.of(kind).near_votes;
        own += cell.of(kind).own_votes;
      }
      others += cell.ofThingsBesidePosts();
    });
    return others > all && own < kOwnShare * all;
  }

  const PlanCells& cells_;
  LowThings low_things_;
  bool aerial_;
};

}  // namespace

void findPosts(const PlanCells& cells, PlanView& view) {
  const PeakFinder peaks(cells, view.aerial);
  view[Channel::pole] = peaks.find({Kind::pole});
  view[Channel::sign] = peaks.find({Kind::sign});
  view[Channel::light] = peaks.find({Kind::light});
  view[Channel::pole_like] = peaks.find({Kind::pole, Kind::sign, Kind::light});
  addUnknown(findColumns(cells), kSameColumn_m, view[Channel::pole_like]);
}

}  // namespace xview::graph
