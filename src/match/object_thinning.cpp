// SPDX-License-Identifier: BSD-3-Clause
#include "object_thinning.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "sparse_grid.h"
#include "xview/types/median.h"

namespace xview {
namespace {

constexpr double kSame = 2.5;       // [m]
constexpr double kClearlyMore = 4;  // times as many points: the other one is a wrong label

using Kept = std::vector<std::uint32_t>;

std::int64_t cellOf(double v) { return static_cast<std::int64_t>(std::floor(v / kSame)); }

bool isSaidBy(const Vertex& v, const Vertex& better) {
  const Eigen::Vector3d d = v.position - better.position;
  if (v.label == better.label) return d.head<2>().squaredNorm() < kSame * kSame;
  return better.points > kClearlyMore * v.points && d.squaredNorm() < kSame * kSame;
}

bool isSaidByAny(const SemanticGraph& graph, const Vertex& v, const SparseGrid<Kept>& kept) {
  const std::int64_t cx = cellOf(v.position.x()), cy = cellOf(v.position.y());
  for (std::int64_t y = cy - 1; y <= cy + 1; ++y) {
    for (std::int64_t x = cx - 1; x <= cx + 1; ++x) {
      const Kept* cell = kept.find(x, y);
      if (cell && std::any_of(cell->begin(), cell->end(),
                              [&](std::uint32_t k) { return isSaidBy(v, graph.vertices[k]); }))
        return true;
    }
  }
  return false;
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
  SparseGrid<Kept> kept;
  for (const std::uint32_t i : surfaces) {
    const Vertex& v = graph.vertices[i];
    if (isSaidByAny(graph, v, kept)) continue;
    kept.at(cellOf(v.position.x()), cellOf(v.position.y())).push_back(i);
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
  const auto isVague = [&](std::uint32_t i) {
    const auto usual = median.find(graph.vertices[i].label);
    return usual != median.end() && graph.vertices[i].points < usual->second;
  };
  candidates.erase(std::remove_if(candidates.begin(), candidates.end(), isVague), candidates.end());
  return candidates;
}

}  // namespace xview
