// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <functional>

#include "graph/plan_cells.h"
#include "xview/graph/plan_view.h"

namespace xview::graph {
namespace {

constexpr int kTreeReach = 5;
constexpr int kCrownReach = 3;      ///< cells to each side whose heights count as one crown
constexpr float kMinCanopy = 30.f;  ///< summed crown height of a tree [m x cells]

using CellValue = std::function<float(const UprightCell&)>;

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
  std::vector<bool> seen(cells.size(), false);
  const auto member = [&](std::int32_t i) {
    const UprightCell* cell = i < 0 || seen[i] ? nullptr : cells.uprightOf(i);
    return cell && belongs(*cell);
  };
  std::vector<Cluster> clusters;
  for (std::int32_t start = 0; start < static_cast<std::int32_t>(cells.size()); ++start) {
    if (!member(start)) continue;
    const CellIndex::Cell first = cells.cell(start);
    Cluster cluster{{start}, first.x, first.y, first.x, first.y};
    seen[start] = true;
    for (std::size_t k = 0; k < cluster.cells.size(); ++k) {
      const CellIndex::Cell c = cells.cell(cluster.cells[k]);
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

void findClusters(const PlanCells& cells, const ClusterRule& rule, std::vector<PlanSample>& out) {
  for (const Cluster& cluster : connectedCells(cells, rule.belongs)) {
    const double extent =
        kPlanCell_m * (1 + std::max(cluster.max_x - cluster.min_x, cluster.max_y - cluster.min_y));
    if (extent > rule.max_extent_m || extent < rule.min_extent_m) continue;
    float weight = 0, votes = 0, x = 0, y = 0, z = 0, bottom = 1e9f, top = -1e9f;
    for (const std::int32_t i : cluster.cells) {
      const UprightCell& cell = *cells.uprightOf(i);
      const Standing& standing = cell.of(rule.kind);
      if (standing.votes <= 0) continue;
      const float w = rule.weight(cell);
      weight += w;
      votes += standing.votes;
      x += w * standing.sum_x / standing.votes;
      y += w * standing.sum_y / standing.votes;
      z += w * cells.floor[i].height;
      bottom = std::min(bottom, standing.bottom);
      top = std::max(top, standing.top);
    }
    if (weight > 0 && votes >= rule.min_votes && top - bottom > rule.min_span_m &&
        top > rule.min_top_m) {
      out.push_back({x / weight, y / weight, z / weight});
    }
  }
}

/// Crowns: local maxima of the summed height of high vegetation.
void findTrees(const PlanCells& cells, PlanView& view) {
  const ValueGrid crown(cells, [](const UprightCell& c) {
    const Standing& s = c.of(Kind::vegetation);
    return s.high >= 0.5f * kMinVotes ? std::max(0.f, std::min(s.top, 12.f) - 1.f) : 0.f;
  });
  const ValueGrid sums = crown.boxSum(kCrownReach);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (sums[i] < kMinCanopy || !sums.isMaximum(i, kTreeReach)) continue;
    const CellIndex::Cell c = cells.cell(i);
    double weight = 0, x = 0, y = 0;
    for (int dy = -kTreeReach; dy <= kTreeReach; ++dy) {
      for (int dx = -kTreeReach; dx <= kTreeReach; ++dx) {
        const double w = crown.at({c.x + dx, c.y + dy});
        weight += w;
        x += w * (c.x + dx + 0.5);
        y += w * (c.y + dy + 0.5);
      }
    }
    view[Channel::tree].push_back({static_cast<float>(x / weight * kPlanCell_m),
                                   static_cast<float>(y / weight * kPlanCell_m),
                                   cells.floor[i].height});
  }
}

/// Votes of a kind near the ground.
CellValue low(Kind kind) {
  return [kind](const UprightCell& c) { return c.of(kind).low; };
}

}  // namespace

void findPlanObjects(const PlanCells& cells, PlanView& view) {
  const auto isVehicle = [](const UprightCell& c) { return c.holds(Kind::vehicle, 0.4); };
  const auto isTrunk = [](const UprightCell& c) {
    return c.of(Kind::trunk).low >= 0.5f * kMinVotes;
  };
  const auto isLowPlant = [](const UprightCell& c) {
    return c.of(Kind::vegetation).low >= kMinVotes;
  };
  const auto isOther = [](const UprightCell& c) { return c.holds(Kind::other_object, 0.25); };
  const auto one = [](const UprightCell&) { return 1.f; };
  const auto votes = [](const UprightCell& c) { return c.of(Kind::other_object).votes; };
  findClusters(cells, {Kind::vehicle, isVehicle, one, 9.f, 1.25f, 6 * kMinVotes, -1.f, -1.f},
               view[Channel::vehicle]);
  findClusters(cells,
               {Kind::trunk, isTrunk, low(Kind::trunk), 2.6f, 0.f, 2 * kMinVotes, 0.6f, -1.f},
               view[Channel::trunk]);
  findClusters(
      cells,
      {Kind::vegetation, isLowPlant, low(Kind::vegetation), 2.1f, 0.f, 3 * kMinVotes, -1.f, 2.2f},
      view[Channel::trunk]);
  findClusters(cells, {Kind::other_object, isOther, votes, 4.f, 0.f, 2 * kMinVotes, -1.f, -1.f},
               view[Channel::other_object]);
  findTrees(cells, view);
}

}  // namespace xview::graph
