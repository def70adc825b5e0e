// SPDX-License-Identifier: BSD-3-Clause
#include "xview/view/match_drawing.h"

#include <algorithm>
#include <set>
#include <utility>

#include "xview/view/graph_mesh.h"

namespace xview {
namespace {

constexpr double kLeastLift_m = 10;

using Pair = std::pair<std::uint32_t, std::uint32_t>;  // query vertex, map vertex

Eigen::AlignedBox3d boundsOf(const SemanticGraph& graph, const Eigen::Isometry3d& T) {
  Eigen::AlignedBox3d box;
  for (const Vertex& v : graph.vertices) {
    if (v.position.allFinite()) box.extend(Eigen::Vector3d(T * v.position));
  }
  return box;
}

double liftOf(const MatchDrawingStyle& style, const Eigen::AlignedBox3d& query) {
  if (style.lift_m > 0) return style.lift_m;
  return query.isEmpty() ? kLeastLift_m
                         : std::max(kLeastLift_m, query.sizes().head<2>().maxCoeff() / 3);
}

/// The vertices that fulfil keep(i), with the edges among them.
template <class Keep>
SemanticGraph partOf(const SemanticGraph& graph, Keep&& keep) {
  SemanticGraph part;
  std::vector<std::int64_t> place(graph.size(), -1);
  for (std::uint32_t i = 0; i < graph.size(); ++i) {
    if (!keep(i)) continue;
    place[i] = static_cast<std::int64_t>(part.vertices.size());
    part.vertices.push_back(graph.vertices[i]);
  }
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const auto& [i, j] : graph.edges()) {
    if (place[i] >= 0 && place[j] >= 0) {
      edges.emplace_back(static_cast<std::uint32_t>(place[i]),
                         static_cast<std::uint32_t>(place[j]));
    }
  }
  part.setEdges(edges);
  return part;
}

SemanticGraph mapNearQuery(const SemanticGraph& map, const Eigen::AlignedBox3d& query,
                           const std::vector<Correspondence>& kept, double reach_m) {
  std::set<std::uint32_t> matched;
  for (const Correspondence& c : kept) matched.insert(c.map);
  return partOf(map, [&](std::uint32_t i) {
    return matched.count(i) > 0 ||
           (!query.isEmpty() && query.exteriorDistance(map.vertices[i].position) <= reach_m);
  });
}

}  // namespace

ColorMesh drawMatches(const SemanticGraph& map, const SemanticGraph& query, const LabelSet& labels,
                      const Eigen::Isometry3d& T_map_query,
                      const std::vector<Correspondence>& putative,
                      const std::vector<Correspondence>& kept, const MatchDrawingStyle& style) {
  const Eigen::AlignedBox3d bounds = boundsOf(query, T_map_query);
  const Eigen::Isometry3d T_scene_query =
      Eigen::Translation3d(0, 0, liftOf(style, bounds)) * T_map_query;

  GraphMeshStyle map_style, query_style;
  map_style.vertex_radius_m = query_style.vertex_radius_m =
      typicalVertexRadius(map.empty() ? query : map);
  query_style.edge_color = {90, 130, 200};
  ColorMesh mesh = style.reach_m > 0 ? graphMesh(mapNearQuery(map, bounds, kept, style.reach_m),
                                                 labels, map_style)
                                     : graphMesh(map, labels, map_style);
  append(mesh, graphMesh(query, labels, query_style, T_scene_query));

  const auto line = [&](const Correspondence& c, double radius_m, const Color& color) {
    if (c.query >= query.size() || c.map >= map.size()) return;
    const Eigen::Vector3d from = T_scene_query * query.vertices[c.query].position,
                          to = map.vertices[c.map].position;
    if (from.allFinite() && to.allFinite()) addTube(mesh, from, to, radius_m, color);
  };
  std::set<Pair> kept_pairs;
  for (const Correspondence& c : kept) kept_pairs.insert({c.query, c.map});
  const std::size_t step = 1 + putative.size() / std::max<std::size_t>(1, style.most_putative);
  for (std::size_t i = 0; i < putative.size(); i += step) {
    if (kept_pairs.count({putative[i].query, putative[i].map}) == 0) {
      line(putative[i], map_style.vertex_radius_m / 16, style.putative_color);
    }
  }
  for (const Correspondence& c : kept) line(c, map_style.vertex_radius_m / 5, style.kept_color);
  return mesh;
}

}  // namespace xview
