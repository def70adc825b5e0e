// SPDX-License-Identifier: BSD-3-Clause
#include "graph/plan_objects.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "graph/plan_columns.h"
#include "graph/value_grid.h"

namespace xview {
namespace {

constexpr int kPeakReach = 3;  ///< a peak is the largest within so many cells
constexpr int kTreeReach = 5;
constexpr float kMinPoleShare = 0.25f;  ///< of the votes of the other upright classes in the cell
/// A post may stand before a wall, so that less than that share is its own. Then the places where
/// it outvotes the wall speak for it, with half their votes, because walls have wrong labels here
/// and there.
constexpr float kBeforeWall = 0.5f;
constexpr float kMinCanopy = 30.f;  ///< summed crown height of a tree [m x cells]

/// Weighted mean of the pole-like points in the 3x3 cells around a peak.
PlanSample peakCentre(const PlanCells& cells, const ValueGrid& value, CellIndex::Cell c) {
  float weight = 0, x = 0, y = 0;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const UprightCell* cell = cells.uprightAt(c.x + dx, c.y + dy);
      const float w = value.at(c.x + dx, c.y + dy);
      if (!cell || w <= 0) continue;
      float votes = 0, sum_x = 0, sum_y = 0;
      for (const Standing* s = cell->first; s != cell->last; ++s) {
        if (!isPoleLike(s->kind)) continue;
        votes += s->votes;
        sum_x += s->sum_x;
        sum_y += s->sum_y;
      }
      if (votes <= 0) continue;
      weight += w;
      x += w * sum_x / votes;
      y += w * sum_y / votes;
    }
  }
  if (weight <= 0) return {};
  return {x / weight, y / weight, cells.floor[cells.index.find(c.x, c.y)].height};
}

/// Greatest height of anything pole-like in the 3x3 cells around one.
float poleTop(const PlanCells& cells, CellIndex::Cell c) {
  float top = 0;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      const UprightCell* cell = cells.uprightAt(c.x + dx, c.y + dy);
      if (!cell) continue;
      for (const Standing* s = cell->first; s != cell->last; ++s) {
        if (isPoleLike(s->kind)) top = std::max(top, s->top);
      }
    }
  }
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

/// Peaks of the votes of pole-like things.
class PeakFinder {
 public:
  PeakFinder(const PlanCells& cells, const PlanOptions& options)
      : cells_(cells),
        low_things_(cells, options.min_votes),
        min_votes_(static_cast<float>(options.peak_votes * options.min_votes)) {}

  std::vector<PlanSample> find(const std::vector<Kind>& kinds) const {
    const ValueGrid value(cells_, [&](const UprightCell& cell) {
      float votes = 0, own = 0;
      for (const Kind kind : kinds) {
        votes += cell.nearOf(kind);
        own += cell.ownOf(kind);
      }
      const float others = cell.of(Kind::building) + cell.of(Kind::fence) +
                           cell.of(Kind::vegetation) + cell.of(Kind::vehicle);
      return votes >= kMinPoleShare * others ? votes : kBeforeWall * own;
    });
    const ValueGrid sums = value.boxSum(1);
    std::vector<PlanSample> peaks;
    for (std::size_t i = 0; i < cells_.index.size(); ++i) {
      if (sums[i] <= 0 || sums[i] < min_votes_) continue;
      const CellIndex::Cell cell = cells_.index.cells()[i];
      const bool is_peak = sums.isMaximum(i, kPeakReach) ||
                           (sums.isMaximum(i, kPeakReach - 1) && standsApart(kinds, value, cell));
      if (is_peak && !low_things_.contain(cell, sums[i]))
        peaks.push_back(peakCentre(cells_, value, cell));
    }
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
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const UprightCell* cell = cells_.uprightAt(c.x + dx, c.y + dy);
        if (!cell || value.at(c.x + dx, c.y + dy) <= 0) continue;
        for (const Kind kind : kinds) low += cell->lowOf(kind);
      }
    }
    return low >= kLowShare * own;
  }

  const PlanCells& cells_;
  LowThings low_things_;
  float min_votes_;
};

/// Adds the columns that are not there yet.
void addColumns(const std::vector<PlanSample>& columns, std::vector<PlanSample>& pole_like) {
  constexpr float kSame_m = 1.5f;
  const std::vector<PlanSample> labelled = pole_like;
  for (const PlanSample& column : columns) {
    const bool is_known = std::any_of(labelled.begin(), labelled.end(), [&](const PlanSample& p) {
      return std::hypot(p.x - column.x, p.y - column.y) < kSame_m;
    });
    if (!is_known) pole_like.push_back(column);
  }
}

void findPoleLike(const PlanCells& cells, const PlanOptions& options, PlanView& view) {
  constexpr double kColumnVotes = 20;  // of min_votes, at each height
  const PeakFinder peaks(cells, options);
  view[Channel::pole] = peaks.find({Kind::pole});
  view[Channel::sign] = peaks.find({Kind::sign});
  view[Channel::light] = peaks.find({Kind::light});
  view[Channel::pole_like] = peaks.find({Kind::pole, Kind::sign, Kind::light});
  addColumns(findColumns(cells, kColumnVotes * options.min_votes), view[Channel::pole_like]);
}

/// What is asked of an 8-connected cluster of cells.
struct ClusterRule {
  Kind kind;
  std::function<bool(const UprightCell&)> belongs;
  CellValue weight;  ///< of a cell for the centre
  float max_extent_m;
  float min_extent_m;
  float min_votes;
  float min_span_m;  ///< top minus bottom
  float min_top_m;
};

struct Cluster {
  std::vector<std::int32_t> cells;
  std::int32_t min_x, min_y, max_x, max_y;
};

std::vector<Cluster> connectedCells(const PlanCells& cells,
                                    const std::function<bool(const UprightCell&)>& belongs) {
  std::vector<bool> seen(cells.index.size(), false);
  const auto member = [&](std::int32_t i) {
    const UprightCell* cell = i < 0 || seen[i] ? nullptr : cells.uprightOf(i);
    return cell && belongs(*cell);
  };
  std::vector<Cluster> clusters;
  for (std::int32_t start = 0; start < static_cast<std::int32_t>(cells.index.size()); ++start) {
    if (!member(start)) continue;
    const CellIndex::Cell first = cells.index.cells()[start];
    Cluster cluster{{start}, first.x, first.y, first.x, first.y};
    seen[start] = true;
    for (std::size_t k = 0; k < cluster.cells.size(); ++k) {
      const CellIndex::Cell c = cells.index.cells()[cluster.cells[k]];
      cluster.min_x = std::min(cluster.min_x, c.x);
      cluster.max_x = std::max(cluster.max_x, c.x);
      cluster.min_y = std::min(cluster.min_y, c.y);
      cluster.max_y = std::max(cluster.max_y, c.y);
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const std::int32_t j = cells.index.find(c.x + dx, c.y + dy);
          if (!member(j)) continue;
          seen[j] = true;
          cluster.cells.push_back(j);
        }
      }
    }
    clusters.push_back(std::move(cluster));
  }
  return clusters;
}

void findClusters(const PlanCells& cells, double cell_m, const ClusterRule& rule,
                  std::vector<PlanSample>& out) {
  for (const Cluster& cluster : connectedCells(cells, rule.belongs)) {
    const double extent =
        cell_m * (1 + std::max(cluster.max_x - cluster.min_x, cluster.max_y - cluster.min_y));
    if (extent > rule.max_extent_m || extent < rule.min_extent_m) continue;
    float weight = 0, votes = 0, x = 0, y = 0, z = 0, bottom = 1e9f, top = -1e9f;
    for (const std::int32_t i : cluster.cells) {
      const UprightCell& cell = *cells.uprightOf(i);
      const Standing* standing = cell.find(rule.kind);
      if (!standing) continue;
      const float w = rule.weight(cell);
      weight += w;
      votes += standing->votes;
      x += w * standing->sum_x / standing->votes;
      y += w * standing->sum_y / standing->votes;
      z += w * cells.floor[i].height;
      bottom = std::min(bottom, standing->bottom);
      top = std::max(top, standing->top);
    }
    if (weight > 0 && votes >= rule.min_votes && top - bottom > rule.min_span_m &&
        top > rule.min_top_m) {
      out.push_back({x / weight, y / weight, z / weight});
    }
  }
}

/// Crowns: local maxima of the summed height of high vegetation.
void findTrees(const PlanCells& cells, const PlanOptions& options, PlanView& view) {
  const ValueGrid crown(cells, [&](const UprightCell& c) {
    const Standing* s = c.find(Kind::vegetation);
    return s && s->high >= 0.5 * options.min_votes ? std::max(0.f, std::min(s->top, 12.f) - 1.f)
                                                   : 0.f;
  });
  const ValueGrid sums = crown.boxSum(kPeakReach);
  for (std::size_t i = 0; i < cells.index.size(); ++i) {
    if (sums[i] < kMinCanopy || !sums.isMaximum(i, kTreeReach)) continue;
    const CellIndex::Cell c = cells.index.cells()[i];
    double weight = 0, x = 0, y = 0;
    for (int dy = -kTreeReach; dy <= kTreeReach; ++dy) {
      for (int dx = -kTreeReach; dx <= kTreeReach; ++dx) {
        const double w = crown.at(c.x + dx, c.y + dy);
        weight += w;
        x += w * (c.x + dx + 0.5);
        y += w * (c.y + dy + 0.5);
      }
    }
    view[Channel::tree].push_back({static_cast<float>(x / weight * options.cell_m),
                                   static_cast<float>(y / weight * options.cell_m),
                                   cells.floor[i].height});
  }
}

}  // namespace

void findPlanObjects(const PlanCells& cells, const PlanOptions& options, PlanView& view) {
  const auto votes = static_cast<float>(options.min_votes);
  findPoleLike(cells, options, view);
  findClusters(
      cells, options.cell_m,
      {Kind::vehicle, [=](const UprightCell& c) { return c.holds(Kind::vehicle, votes, 0.4); },
       [](const UprightCell&) { return 1.f; }, 9.f, 1.25f, 6 * votes, -1.f, -1.f},
      view[Channel::vehicle]);
  findClusters(
      cells, options.cell_m,
      {Kind::trunk, [=](const UprightCell& c) { return c.lowOf(Kind::trunk) >= 0.5f * votes; },
       [](const UprightCell& c) { return c.lowOf(Kind::trunk); }, 2.6f, 0.f, 2 * votes, 0.6f, -1.f},
      view[Channel::trunk]);
  findClusters(
      cells, options.cell_m,
      {Kind::vegetation, [=](const UprightCell& c) { return c.lowOf(Kind::vegetation) >= votes; },
       [](const UprightCell& c) { return c.lowOf(Kind::vegetation); }, 2.1f, 0.f, 3 * votes, -1.f,
       2.2f},
      view[Channel::trunk]);
  findClusters(cells, options.cell_m,
               {Kind::other_object,
                [=](const UprightCell& c) { return c.holds(Kind::other_object, votes, 0.25); },
                [](const UprightCell& c) { return c.of(Kind::other_object); }, 4.f, 0.f, 2 * votes,
                -1.f, -1.f},
               view[Channel::other_object]);
  findTrees(cells, options, view);
}

}  // namespace xview
