// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "xview/graph/edges.h"
#include "xview/graph/merge_plan_views.h"
#include "xview/mapper.h"
#include "xview/types/error.h"

namespace xview {
namespace {

constexpr double kSameUp_rad = 0.03;

/// Finds vertices of a class near a point.
class VertexGrid {
 public:
  explicit VertexGrid(double cell_m) : cell_m_(cell_m) {}
  void add(const Vertex& v, std::uint32_t number) {
    cells_[keyOf(v.label, v.position, 0, 0)].push_back(number);
  }
  /// Number of the nearest one within `reach_m` (at most the cell size), or -1.
  std::int64_t nearest(const std::vector<Vertex>& vertices, const Vertex& v, double reach_m) const {
    std::int64_t best = -1;
    double best_distance = reach_m;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const auto it = cells_.find(keyOf(v.label, v.position, dx, dy));
        if (it == cells_.end()) continue;
        for (const std::uint32_t i : it->second) {
          const double d = (vertices[i].position - v.position).norm();
          if (d <= best_distance) {
            best_distance = d;
            best = i;
          }
        }
      }
    }
    return best;
  }

 private:
  using Key = std::tuple<std::uint32_t, std::int64_t, std::int64_t>;
  Key keyOf(std::uint32_t label, const Eigen::Vector3d& p, int dx, int dy) const {
    return {label, static_cast<std::int64_t>(std::floor(p.x() / cell_m_)) + dx,
            static_cast<std::int64_t>(std::floor(p.y() / cell_m_)) + dy};
  }
  double cell_m_;
  std::map<Key, std::vector<std::uint32_t>> cells_;
};

/// The mean of both, weighted by how often each was seen.
void absorb(Vertex& vertex, const Vertex& other) {
  const double a = vertex.observations, b = other.observations, share = b / std::max(1.0, a + b);
  vertex.position += share * (other.position - vertex.position);
  vertex.extent += share * (other.extent - vertex.extent);
  vertex.sigma_m = std::sqrt((1 - share) * vertex.sigma_m * vertex.sigma_m +
                             share * other.sigma_m * other.sigma_m);
  vertex.observations += other.observations;
  vertex.points += other.points;
}

/// Edges found in images and edges of a radius say different things of the same vertices.
void requireSameSpace(const SemanticMap& map, const SemanticMap& addition) {
  if (map.graph.space == addition.graph.space || map.graph.empty() || addition.graph.empty())
    return;
  throw Error(addition.sources.empty() ? "addition" : addition.sources.front(),
              std::string("its graph_space is ") + toString(addition.graph.space) +
                  ", that of the map is " + toString(map.graph.space));
}

void appendGraph(SemanticGraph& graph, const SemanticGraph& addition, const LabelSet& labels,
                 const Options& options) {
  if (graph.empty()) graph.space = addition.space;
  const bool in_images = graph.space == GraphSpace::image;
  const double object_m = options.merge.object_m;
  const double surface_m =
      in_images ? options.merge.first_observation_m : options.merge.surface_m / 2;
  VertexGrid grid(std::max(object_m, surface_m));
  for (std::uint32_t i = 0; i < graph.size(); ++i) grid.add(graph.vertices[i], i);
  std::vector<std::uint32_t> now_at;  // of the vertices of the addition
  for (const Vertex& v : addition.vertices) {
    const double reach = labels.role(v.label) == Role::surface ? surface_m : object_m;
    const std::int64_t known = grid.nearest(graph.vertices, v, reach);
    now_at.push_back(
        static_cast<std::uint32_t>(known >= 0 ? known : static_cast<std::int64_t>(graph.size())));
    if (known >= 0)
      absorb(graph.vertices[known], v);
    else
      graph.vertices.push_back(v);
  }
  if (!in_images) return connectByRadius(graph, options.edges);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges = graph.edges();
  for (const auto& [a, b] : addition.edges()) edges.emplace_back(now_at[a], now_at[b]);
  graph.setEdges(edges);
}

void appendCloud(LabelledCloud& cloud, const LabelledCloud& addition, double voxel_m) {
  if (cloud.empty()) {
    cloud = addition;
    return;
  }
  const Eigen::Vector3f shift = (addition.origin - cloud.origin).cast<float>();
  for (Point& point : cloud.points) point.instance = 0;  // numbers of two recordings differ
  for (Point point : addition.points) {
    point.getVector3fMap() += shift;
    point.instance = 0;
    cloud.points.push_back(point);
  }
  cloud = thinByVoxel(cloud, voxel_m);
}

}  // namespace

void appendToMap(SemanticMap& map, const SemanticMap& addition, const Options& options) {
  if (map.labels != addition.labels) {
    throw Error(addition.sources.empty() ? "addition" : addition.sources.front(),
                "its classes (label set '" + addition.labels.name() +
                    "') are not those of the map ('" + map.labels.name() + "')");
  }
  if (!map.plan.known.empty() && !addition.plan.known.empty() &&
      map.plan.upright.angularDistance(addition.plan.upright) > kSameUp_rad) {
    throw Error(
        addition.sources.empty() ? "addition" : addition.sources.front(),
        "its frame is tilted against that of the map; only recordings in one frame can be joined");
  }
  requireSameSpace(map, addition);
  appendGraph(map.graph, addition.graph, map.labels, options);
  mergePlanViews(map.plan, addition.plan);
  appendCloud(map.cloud, addition.cloud, options.map.cloud_voxel_m);
  const auto first_source = static_cast<std::uint32_t>(map.sources.size());
  for (std::size_t i = 0; i < addition.poses.size(); ++i)
    map.addKeyframe(addition.poses[i], addition.frames[i], addition.stamps_s[i],
                    first_source + addition.source_of_pose[i]);
  map.sources.insert(map.sources.end(), addition.sources.begin(), addition.sources.end());
}

}  // namespace xview
