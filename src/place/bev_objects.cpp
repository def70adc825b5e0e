// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Geometry>
#include <algorithm>

#include <functional>

#include "place/bev_cells.h"
#include "place/bev_grid.h"

namespace xview {
namespace {

constexpr int kTreeReach = 5;
constexpr int kCrownReach = 3;      ///< cells to each side whose heights count as one crown
constexpr float kMinCanopy = 30.f;  ///< summed crown height of a tree [m x cells]

using CellValue = std::function<float(const ObstacleCell&)>;

/// What is asked of an 8-connected cluster of cells.
struct ClusterRule {
  Kind kind;
  std::function<bool(const ObstacleCell&)> belongs;
  CellValue weight;  ///< of a cell for the centre
  float max_extent_m;
  float min_extent_m;
  float min_weight;
  float min_span_m;  ///< top minus bottom
  float min_top_m;
};

void findClusters(const BevCells& cells, const ClusterRule& rule, std::vector<BevSample>& out) {
  const auto belongs = [&](std::int32_t i) {
    const ObstacleCell* cell = cells.obstacleCellOf(i);
    return cell && rule.belongs(*cell);
  };
  for (const std::vector<std::int32_t>& cluster : connectedCells(cells.index, belongs)) {
    Eigen::AlignedBox2i box;
    for (const std::int32_t i : cluster)
      box.extend(Eigen::Vector2i(cells.cell(i).x, cells.cell(i).y));
    const double extent = kBevCell_m * (1 + box.sizes().maxCoeff());
    if (extent > rule.max_extent_m || extent < rule.min_extent_m) continue;
    float weight = 0, weight_sum = 0, x = 0, y = 0, z = 0, bottom = 1e9f, top = -1e9f;
    for (const std::int32_t i : cluster) {
      const ObstacleCell& cell = *cells.obstacleCellOf(i);
      const ClassColumn& column = cell.of(rule.kind);
      if (column.weight_sum <= 0) continue;
      const float w = rule.weight(cell);
      weight += w;
      weight_sum += column.weight_sum;
      x += w * column.sum_x / column.weight_sum;
      y += w * column.sum_y / column.weight_sum;
      z += w * cells.floor[i].height;
      bottom = std::min(bottom, column.bottom);
      top = std::max(top, column.top);
    }
    if (weight > 0 && weight_sum >= rule.min_weight && top - bottom > rule.min_span_m &&
        top > rule.min_top_m) {
      out.push_back({x / weight, y / weight, z / weight});
    }
  }
}

/// Crowns: local maxima of the summed height of high vegetation.
void findTrees(const BevCells& cells, BevGrid& view) {
  const ValueGrid crown(cells, [](const ObstacleCell& c) {
    const ClassColumn& s = c.of(Kind::vegetation);
    return s.high >= 0.5f * kMinWeight ? std::max(0.f, std::min(s.top, 12.f) - 1.f) : 0.f;
  });
  const ValueGrid sums = crown.boxSum(kCrownReach);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (sums[i] < kMinCanopy || !sums.isMaximum(i, kTreeReach)) continue;
    double weight = 0, x = 0, y = 0;
    cells.index.forAround(i, kTreeReach, [&](std::int32_t j) {
      const double w = crown[j];
      weight += w;
      x += w * (cells.cell(j).x + 0.5);
      y += w * (cells.cell(j).y + 0.5);
    });
    view[BevChannel::tree].push_back({static_cast<float>(x / weight * kBevCell_m),
                                      static_cast<float>(y / weight * kBevCell_m),
                                      cells.floor[i].height});
  }
}

/// Votes of a kind near the ground.
CellValue low(Kind kind) {
  return [kind](const ObstacleCell& c) { return c.of(kind).low; };
}

constexpr float kPeakWeight = 2;        ///< that make a pole, sign or light
constexpr int kPeakReach = 3;           ///< radius in cells in which a peak is the largest
constexpr float kMinPoleShare = 0.25f;  ///< of the weights of the other upright classes in the cell

/// Weighted mean of the pole-like points in the 3x3 cells around a peak.
BevSample peakCentre(const BevCells& cells, const ValueGrid& value, std::size_t peak) {
  float weight = 0, x = 0, y = 0;
  cells.index.forAround(peak, 1, [&](std::int32_t i) {
    const float w = value[i];
    if (w <= 0) return;
    const ObstacleCell& cell = *cells.obstacleCellOf(i);
    float weight_sum = 0, sum_x = 0, sum_y = 0;
    for (const ClassColumn* s = cell.first; s != cell.last; ++s) {
      if (!isPoleLike(s->kind)) continue;
      weight_sum += s->weight_sum;
      sum_x += s->sum_x;
      sum_y += s->sum_y;
    }
    if (weight_sum <= 0) return;
    weight += w;
    x += w * sum_x / weight_sum;
    y += w * sum_y / weight_sum;
  });
  if (weight <= 0) return {};
  return {x / weight, y / weight, cells.floor[peak].height};
}

/// Peaks of the weights of some kinds, where nothing else has many more.
std::vector<BevSample> peaksOf(const std::vector<Kind>& kinds, const BevCells& cells) {
  const ValueGrid value(cells, [&](const ObstacleCell& cell) {
    float weight_sum = 0;
    for (const Kind kind : kinds) weight_sum += cell.of(kind).near_weight;
    return weight_sum >= kMinPoleShare * cell.ofObjectsBesidePosts() ? weight_sum : 0.f;
  });
  const ValueGrid sums = value.boxSum(1);
  std::vector<BevSample> peaks;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (sums[i] >= kPeakWeight && sums.isMaximum(i, kPeakReach))
      peaks.push_back(peakCentre(cells, value, i));
  }
  return peaks;
}

}  // namespace

void findBevObjects(const BevCells& cells, BevGrid& view) {
  const auto isVehicle = [](const ObstacleCell& c) { return c.holds(Kind::vehicle, 0.4); };
  const auto isTrunk = [](const ObstacleCell& c) {
    return c.of(Kind::trunk).low >= 0.5f * kMinWeight;
  };
  const auto isLowPlant = [](const ObstacleCell& c) {
    return c.of(Kind::vegetation).low >= kMinWeight;
  };
  const auto isOther = [](const ObstacleCell& c) { return c.holds(Kind::other_object, 0.25); };
  const auto one = [](const ObstacleCell&) { return 1.f; };
  const auto weight_sum = [](const ObstacleCell& c) { return c.of(Kind::other_object).weight_sum; };
  findClusters(cells, {Kind::vehicle, isVehicle, one, 9.f, 1.25f, 6 * kMinWeight, -1.f, -1.f},
               view[BevChannel::vehicle]);
  findClusters(cells,
               {Kind::trunk, isTrunk, low(Kind::trunk), 2.6f, 0.f, 2 * kMinWeight, 0.6f, -1.f},
               view[BevChannel::trunk]);
  findClusters(
      cells,
      {Kind::vegetation, isLowPlant, low(Kind::vegetation), 2.1f, 0.f, 3 * kMinWeight, -1.f, 2.2f},
      view[BevChannel::trunk]);
  findClusters(cells,
               {Kind::other_object, isOther, weight_sum, 4.f, 0.f, 2 * kMinWeight, -1.f, -1.f},
               view[BevChannel::other_object]);
  findTrees(cells, view);
}

void findPosts(const BevCells& cells, BevGrid& view) {
  view[BevChannel::pole] = peaksOf({Kind::pole}, cells);
  view[BevChannel::sign] = peaksOf({Kind::sign}, cells);
  view[BevChannel::light] = peaksOf({Kind::light}, cells);
  view[BevChannel::pole_like] = peaksOf({Kind::pole, Kind::sign, Kind::light}, cells);
}

}  // namespace xview
