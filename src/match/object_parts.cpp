// SPDX-License-Identifier: BSD-3-Clause
#include "object_parts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

namespace xview {
namespace {

constexpr double kCell = 75;                                   // [m] of the count of vertices
constexpr double kApart = 400;                                 // [m] between parts
constexpr double kSmallestRadius = 120, kLargestRadius = 400;  // [m]
constexpr std::size_t kEnough = 80;     // vertices that tell a place from all others
constexpr double kSurfaceWeight = 0.2;  // of a vertex of a surface, against that of an object

struct Known {
  Eigen::Vector2d p;
  double weight;
};

std::vector<Known> knownVertices(const SemanticGraph& query, const ObjectMap& map) {
  std::vector<Known> known;
  for (const Vertex& v : query.vertices) {
    const std::optional<std::uint16_t> slot = map.slotOf(v.label);
    if (!slot || !v.position.allFinite()) continue;
    known.push_back({v.position.head<2>(), map.classes()[*slot].is_surface ? kSurfaceWeight : 1.0});
  }
  return known;
}

/// The smallest radius with enough vertices.
double radiusAround(const Eigen::Vector2d& centre, const std::vector<Known>& known) {
  std::vector<double> distances;
  for (const Known& k : known) distances.push_back((k.p - centre).norm());
  const std::size_t last = std::min(kEnough, distances.size()) - 1;
  std::nth_element(distances.begin(), distances.begin() + static_cast<std::ptrdiff_t>(last),
                   distances.end());
  return std::clamp(distances[last], kSmallestRadius, kLargestRadius);
}

}  // namespace

QueryPart wholeOf(const SemanticGraph& query, const ObjectMap& map) {
  const std::vector<Known> known = knownVertices(query, map);
  QueryPart whole;
  if (known.empty()) return whole;
  for (const Known& k : known) whole.centre += k.p / static_cast<double>(known.size());
  for (const Known& k : known) whole.radius = std::max(whole.radius, (k.p - whole.centre).norm());
  return whole;
}

std::vector<QueryPart> denseParts(const SemanticGraph& query, const ObjectMap& map,
                                  std::size_t count) {
  const std::vector<Known> known = knownVertices(query, map);
  using Cell = std::pair<std::int64_t, std::int64_t>;
  const auto cellOf = [](const Eigen::Vector2d& p) {
    return Cell{static_cast<std::int64_t>(std::floor(p.y() / kCell)),
                static_cast<std::int64_t>(std::floor(p.x() / kCell))};
  };
  struct Sum {
    double weight = 0, n = 0;
    Eigen::Vector2d p = Eigen::Vector2d::Zero();
  };
  std::map<Cell, Sum> around;  // of the 3x3 cells
  for (const Known& k : known) {
    const Cell cell = cellOf(k.p);
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        Sum& sum = around[{cell.first + dy, cell.second + dx}];
        sum.weight += k.weight;
        sum.n += 1;
        sum.p += k.p;
      }
    }
  }
  std::vector<std::pair<double, Eigen::Vector2d>> centres;
  for (const auto& [cell, sum] : around) centres.push_back({sum.weight, sum.p / sum.n});
  std::stable_sort(centres.begin(), centres.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<QueryPart> parts;
  for (const auto& [weight, centre] : centres) {
    if (parts.size() >= count) break;
    const bool is_new = std::none_of(
        parts.begin(), parts.end(),
        [&, c = centre](const QueryPart& p) { return (p.centre - c).norm() < kApart; });
    if (is_new) parts.push_back({centre, radiusAround(centre, known)});
  }
  return parts;
}

}  // namespace xview
