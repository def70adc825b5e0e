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

std::int64_t cellOf(double v) { return static_cast<std::int64_t>(std::floor(v / kSame)); }

bool isSaidBy(const Vertex& v, const Vertex& better) {
  const Eigen::Vector3d d = v.position - better.position;
  if (v.label == better.label) return d.head<2>().squaredNorm() < kSame * kSame;
  return better.points > kClearlyMore * v.points && d.squaredNorm() < kSame * kSame;
}

/// The vertices that stay, chained by cell: a list per cell would take more memory than the map.
class KeptVertices {
 public:
  explicit KeptVertices(const SemanticGraph& graph) : graph_(graph) {}

  void add(std::uint32_t vertex) {
    const Eigen::Vector3d& p = graph_.vertices[vertex].position;
    std::uint32_t& last = last_.at(cellOf(p.x()), cellOf(p.y()));
    links_.push_back({vertex, last});
    last = static_cast<std::uint32_t>(links_.size());
  }

  bool anySays(const Vertex& v) const {
    const std::int64_t cx = cellOf(v.position.x()), cy = cellOf(v.position.y());
    for (std::int64_t y = cy - 1; y <= cy + 1; ++y) {
      for (std::int64_t x = cx - 1; x <= cx + 1; ++x) {
        const std::uint32_t* last = last_.find(x, y);
        for (std::uint32_t k = last ? *last : 0; k > 0; k = links_[k - 1].before)
          if (isSaidBy(v, graph_.vertices[links_[k - 1].vertex])) return true;
      }
    }
    return false;
  }

 private:
  /// Links are counted from 1; 0 = none.
  struct Link {
    std::uint32_t vertex, before;
  };

  const SemanticGraph& graph_;
  SparseGrid<std::uint32_t> last_;  ///< link of each cell
  std::vector<Link> links_;
};

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
  KeptVertices kept(graph);
  for (const std::uint32_t i : surfaces) {
    if (kept.anySays(graph.vertices[i])) continue;
    kept.add(i);
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
