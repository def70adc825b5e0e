// SPDX-License-Identifier: BSD-3-Clause
#include "search/object_query.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "base/cells.h"
#include "base/median.h"

namespace xview::search {
namespace {

constexpr double kSame = 2.5;       // [m]
constexpr double kClearlyMore = 4;  // times as many points: the other one is a wrong label

constexpr double kSeenShare =
    0.25;  // of the expected number: below, the sensor does not see the class
constexpr double kThinning =
    0.9;  // of the gap: samples of the same spacing must not lose every second one
constexpr std::size_t kMostSamples = 300;  // more do not make the search any surer
constexpr double kCoverageCells = 400;     // across the query, at most
constexpr double kCoarseCoverage = 3;      // [m] larger cells say nothing about a missing object
constexpr double kFading_m = 1.5;          // [m] half the width of the rim of what the query covers
constexpr double kTakenFor = 1.5;   // [m] closer to a vertex, an object may have been taken for it
constexpr double kSameSurface = 4;  // [m] samples of one piece of a surface are this close
constexpr float kFarAway = 1e9f;
constexpr std::uint8_t kNoBit = 255;

bool isExplainedBy(const Vertex& v, const Vertex& better) {
  const Eigen::Vector3d d = v.position - better.position;
  if (v.label == better.label) return d.head<2>().squaredNorm() < kSame * kSame;
  return better.points > kClearlyMore * v.points && d.squaredNorm() < kSame * kSame;
}

Eigen::Vector3d meanOf(const std::vector<std::pair<Eigen::Vector3d, QueryItem>>& items) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& [position, item] : items) sum += position;
  return items.empty() ? sum : Eigen::Vector3d(sum / static_cast<double>(items.size()));
}

}  // namespace

std::vector<std::uint32_t> distinctFromAbove(const SemanticGraph& graph,
                                             const std::vector<std::uint32_t>& candidates,
                                             const std::function<bool(std::uint32_t)>& is_surface) {
  std::vector<std::uint32_t> distinct, surfaces;
  for (const std::uint32_t i : candidates) {
    (is_surface(graph.vertices[i].label) ? surfaces : distinct).push_back(i);
  }
  std::sort(surfaces.begin(), surfaces.end(), [&](std::uint32_t a, std::uint32_t b) {
    const auto key = [&](std::uint32_t i) {
      const Vertex& v = graph.vertices[i];
      return std::make_tuple(~v.points, ~v.observations, i);
    };
    return key(a) < key(b);
  });
  CellLists kept;
  for (const std::uint32_t i : surfaces) {
    const Vertex& v = graph.vertices[i];
    const ClassCell cell = cellOf({v.position.x(), v.position.y(), 0}, kSame, 0);
    if (kept.anyAround(cell, [&](std::size_t j) { return isExplainedBy(v, graph.vertices[j]); }))
      continue;
    kept.add(cell, i);
    distinct.push_back(i);
  }
  std::sort(distinct.begin(), distinct.end());
  return distinct;
}

std::vector<std::uint32_t> wellSeen(const SemanticGraph& graph,
                                    std::vector<std::uint32_t> candidates,
                                    const std::function<bool(std::uint32_t)>& is_surface) {
  std::map<std::uint32_t, std::vector<std::uint32_t>> points_of_class;
  for (const std::uint32_t i : candidates) {
    const Vertex& v = graph.vertices[i];
    if (is_surface(v.label)) points_of_class[v.label].push_back(v.points);
  }
  std::map<std::uint32_t, std::uint32_t> median;
  for (auto& [label, points] : points_of_class) median[label] = medianOf(std::move(points));
  const auto hasFewPoints = [&](std::uint32_t i) {
    const auto usual = median.find(graph.vertices[i].label);
    return usual != median.end() && graph.vertices[i].points < usual->second;
  };
  candidates.erase(std::remove_if(candidates.begin(), candidates.end(), hasFewPoints),
                   candidates.end());
  return candidates;
}

ObjectQuery::ObjectQuery(const SemanticGraph& graph, const ObjectMap& map,
                         const std::vector<std::uint32_t>& vertices)
    : visible_(map.classes().size(), 0) {
  std::vector<std::uint32_t> inside;
  for (const std::uint32_t i : vertices) {
    const Vertex& v = graph.vertices[i];
    if (map.slotOf(v.label) && v.position.allFinite()) inside.push_back(i);
  }
  const auto isSurface = [&](std::uint32_t label) {
    return map.classes()[*map.slotOf(label)].is_surface;
  };
  std::vector<std::pair<Eigen::Vector3d, QueryItem>> found;
  for (const std::uint32_t i :
       wellSeen(graph, distinctFromAbove(graph, inside, isSurface), isSurface)) {
    const Vertex& v = graph.vertices[i];
    found.push_back({v.position, {0, 0, 0, *map.slotOf(v.label), i}});
  }
  centre_ = meanOf(found);
  for (auto& [position, item] : found) {
    const Eigen::Vector3d p = position - centre_;
    item.x = static_cast<float>(p.x());
    item.y = static_cast<float>(p.y());
    item.z = static_cast<float>(p.z());
    radius_ = std::max(radius_, p.head<2>().norm());
    items_.push_back(item);
    has_heights_ = has_heights_ || std::abs(item.z - items_[0].z) > 1e-3f;
  }
  std::stable_sort(items_.begin(), items_.end(), [&](const QueryItem& a, const QueryItem& b) {
    const auto key = [&](const QueryItem& i) {
      const ObjectClass& model = map.classes()[i.slot];
      return std::make_tuple(model.is_surface, model.mean_density, i.slot);
    };
    return key(a) < key(b);
  });
  findVisibleClasses(map);
  drawCoverage(map, kSeenNear_m);
}

/// Compares the mixture of classes with that of the map.
void ObjectQuery::findVisibleClasses(const ObjectMap& map) {
  const std::vector<ObjectClass>& classes = map.classes();
  std::vector<double> count(classes.size(), 0);
  double map_density = 0;
  for (const QueryItem& item : items_) count[item.slot] += 1;
  for (const ObjectClass& model : classes) map_density += model.mean_density;
  const double per_density = map_density > 0 ? static_cast<double>(items_.size()) / map_density : 0;
  for (std::size_t slot = 0; slot < classes.size(); ++slot) {
    const double expected = per_density * classes[slot].mean_density;
    const double share = (count[slot] + 0.5) / (expected + 0.5);
    visible_[slot] = count[slot] > 0 && share >= kSeenShare ? std::min(1.0, share) : 0;
  }
}

void ObjectQuery::drawCoverage(const ObjectMap& map, double reach_m) {
  reach_ = reach_m;
  const double widest = reach_m + kFading_m;
  const double half = radius_ + widest;
  coverage_cell_ = std::max(1.0, 2 * half / kCoverageCells);
  coverage_side_ = static_cast<int>(2 * half / coverage_cell_) + 3;
  const auto cells = static_cast<std::size_t>(coverage_side_ * coverage_side_);
  nearest_.assign(cells, kFarAway);
  near_surface_.assign(cells, 0);
  surface_bit_.assign(map.classes().size(), kNoBit);
  std::uint8_t bits = 0;
  const double middle = 0.5 * coverage_side_;
  const int reach = static_cast<int>(widest / coverage_cell_) + 1;
  for (const QueryItem& item : items_) {
    std::uint8_t& bit = surface_bit_[item.slot];
    if (bit == kNoBit && map.classes()[item.slot].is_surface && bits < 64) bit = bits++;
    const std::uint64_t mask = bit == kNoBit ? 0 : std::uint64_t{1} << bit;
    const double x = item.x / coverage_cell_ + middle, y = item.y / coverage_cell_ + middle;
    for (int cy = static_cast<int>(y) - reach; cy <= static_cast<int>(y) + reach; ++cy) {
      for (int cx = static_cast<int>(x) - reach; cx <= static_cast<int>(x) + reach; ++cx) {
        if (cx < 0 || cy < 0 || cx >= coverage_side_ || cy >= coverage_side_) continue;
        const double dx = cx + 0.5 - x, dy = cy + 0.5 - y;
        const auto distance = static_cast<float>(std::sqrt(dx * dx + dy * dy) * coverage_cell_);
        const auto cell = static_cast<std::size_t>(cy * coverage_side_ + cx);
        nearest_[cell] = std::min(nearest_[cell], distance);
        if (distance < kSameSurface) near_surface_[cell] |= mask;
      }
    }
  }
}

std::optional<std::size_t> ObjectQuery::coverageCell(double x, double y) const {
  const double middle = 0.5 * coverage_side_;
  const double cx = x / coverage_cell_ + middle, cy = y / coverage_cell_ + middle;
  if (!(cx >= 0 && cy >= 0 && cx < coverage_side_ && cy < coverage_side_)) return std::nullopt;
  return static_cast<std::size_t>(static_cast<int>(cy) * coverage_side_ + static_cast<int>(cx));
}

double ObjectQuery::expectsObject(double x, double y) const {
  const std::optional<std::size_t> cell = coverageCell(x, y);
  if (!cell || coverage_cell_ > kCoarseCoverage) return 0;
  const double distance = nearest_[*cell];
  const double fades = (reach_ + kFading_m - distance) / (2 * kFading_m);
  return std::clamp(std::min(fades, (distance - kTakenFor) / kTakenFor), 0.0, 1.0);
}

double ObjectQuery::expectsSurface(std::uint16_t slot, double x, double y) const {
  const std::optional<std::size_t> cell = coverageCell(x, y);
  if (!cell || surface_bit_[slot] == kNoBit || coverage_cell_ > kCoarseCoverage) return 0;
  if (near_surface_[*cell] >> surface_bit_[slot] & 1) return 0;
  return nearest_[*cell] < kSameSurface ? 1 : 0;
}

std::vector<RasterSample> ObjectQuery::samples(const ObjectMap& map, double gap_m) const {
  const double gap = kThinning * gap_m;
  CellLists kept;  // samples of surfaces
  std::vector<RasterSample> samples;
  for (const QueryItem& item : items_) {
    if (map.classes()[item.slot].is_surface) {
      const ClassCell cell = cellOf({item.x, item.y, 0}, gap, item.slot);
      const bool is_taken = kept.anyAround(cell, [&](std::size_t k) {
        const double dx = samples[k].x - item.x, dy = samples[k].y - item.y;
        return dx * dx + dy * dy < gap * gap;
      });
      if (is_taken) continue;
      kept.add(cell, samples.size());
    }
    samples.push_back({item.x, item.y, item.slot});
  }
  if (samples.size() <= kMostSamples) return samples;
  std::vector<RasterSample> some;  // evenly, which keeps the mixture of classes
  for (std::size_t i = 0; i < kMostSamples; ++i)
    some.push_back(samples[i * samples.size() / kMostSamples]);
  return some;
}

double ObjectQuery::emptyRadius() const {
  constexpr std::size_t kNearest = 5;
  std::vector<double> distances;
  for (const QueryItem& item : items_) distances.push_back(std::hypot(item.x, item.y));
  if (distances.empty()) return 0;
  return rankedOf(distances, std::min(kNearest, distances.size()) - 1);
}

}  // namespace xview::search
