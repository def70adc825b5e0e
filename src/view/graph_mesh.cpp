// SPDX-License-Identifier: BSD-3-Clause
#include "xview/view/graph_mesh.h"

#include <algorithm>
#include <vector>

#include "readable_edges.h"
#include "xview/types/median.h"

namespace xview {
namespace {

constexpr double kSmallest_m = 0.15, kLargest_m = 3;
constexpr double kShareOfEdge = 0.06;  // an octahedron is this part of a typical edge

}  // namespace

double typicalVertexRadius(const SemanticGraph& graph) {
  std::vector<double> lengths;
  for (const auto& [i, j] : graph.edges()) {
    const double length = (graph.vertices[i].position - graph.vertices[j].position).norm();
    if (std::isfinite(length)) lengths.push_back(length);
  }
  if (lengths.empty()) return 0.6;
  return std::clamp(kShareOfEdge * medianOf(std::move(lengths)), kSmallest_m, kLargest_m);
}

ColorMesh graphMesh(const SemanticGraph& graph, const LabelSet& labels, const GraphMeshStyle& style,
                    const Eigen::Isometry3d& T_scene_graph) {
  const double vertex_radius =
      style.vertex_radius_m > 0 ? style.vertex_radius_m : typicalVertexRadius(graph);
  const double tube_radius = style.tube_radius_m > 0 ? style.tube_radius_m : vertex_radius / 8;
  ColorMesh mesh;
  for (const Vertex& v : graph.vertices) {
    if (!v.position.allFinite()) continue;
    const double radius = labels.role(v.label) == Role::surface ? vertex_radius / 2 : vertex_radius;
    addOctahedron(mesh, T_scene_graph * v.position, radius,
                  style.vertex_color.value_or(labels.color(v.label)));
  }
  for (const auto& [i, j] : readableEdges(graph)) {
    addTube(mesh, T_scene_graph * graph.vertices[i].position,
            T_scene_graph * graph.vertices[j].position, tube_radius, style.edge_color);
  }
  return mesh;
}

void append(ColorMesh& mesh, const ColorMesh& addition) {
  const auto shift = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), addition.vertices.begin(), addition.vertices.end());
  mesh.colors.insert(mesh.colors.end(), addition.colors.begin(), addition.colors.end());
  for (const auto& t : addition.triangles)
    mesh.triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
}

}  // namespace xview
