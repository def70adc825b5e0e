// SPDX-License-Identifier: BSD-3-Clause
#include "xview/view/color_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "drawing.h"
#include "xview/types/median.h"

namespace xview {
namespace {

constexpr double kSmallest_m = 0.15, kLargest_m = 3;
constexpr double kShareOfEdge = 0.06;  // an octahedron is this part of a typical edge

std::uint32_t addVertex(ColorMesh& mesh, const Eigen::Vector3d& position, const Color& color) {
  mesh.vertices.push_back(position);
  mesh.colors.push_back(color);
  return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
}

}  // namespace

void addOctahedron(ColorMesh& mesh, const Eigen::Vector3d& center, double radius_m,
                   const Color& color) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0})
      addVertex(mesh, center + sign * radius_m * Eigen::Vector3d::Unit(axis), color);
  }
  // Corners 0..5 are +x -x +y -y +z -z; one face per octant, seen from outside counter-clockwise.
  for (std::uint32_t octant = 0; octant < 8; ++octant) {
    const std::uint32_t x = first + (octant & 1), y = first + 2 + ((octant >> 1) & 1),
                        z = first + 4 + (octant >> 2);
    const bool mirrored = ((octant & 1) + ((octant >> 1) & 1) + (octant >> 2)) % 2 == 1;
    if (mirrored) {
      mesh.triangles.push_back({x, z, y});
    } else {
      mesh.triangles.push_back({x, y, z});
    }
  }
}

void addTube(ColorMesh& mesh, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
             double radius_m, const Color& color) {
  const Eigen::Vector3d along = to - from;
  if (!(along.norm() > 0)) return;
  const Eigen::Vector3d u = along.unitOrthogonal(), v = along.normalized().cross(u);
  std::array<std::uint32_t, 3> near{}, far{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double angle = static_cast<double>(k) * 2 * M_PI / 3;
    const Eigen::Vector3d side = radius_m * (std::cos(angle) * u + std::sin(angle) * v);
    near[k] = addVertex(mesh, from + side, color);
    far[k] = addVertex(mesh, to + side, color);
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    mesh.triangles.push_back({near[k], near[next], far[next]});
    mesh.triangles.push_back({near[k], far[next], far[k]});
  }
}

std::string toVtk(const ColorMesh& mesh) {
  std::string text = "# vtk DataFile Version 3.0\nxview\nASCII\nDATASET POLYDATA\n";
  auto out = std::back_inserter(text);
  fmt::format_to(out, "POINTS {} double\n", mesh.vertices.size());
  for (const Eigen::Vector3d& p : mesh.vertices)
    fmt::format_to(out, "{:.3f} {:.3f} {:.3f}\n", p.x(), p.y(), p.z());
  fmt::format_to(out, "POLYGONS {} {}\n", mesh.triangles.size(), 4 * mesh.triangles.size());
  for (const auto& t : mesh.triangles) fmt::format_to(out, "3 {} {} {}\n", t[0], t[1], t[2]);
  std::vector<bool> used(mesh.vertices.size(), false);
  for (const auto& t : mesh.triangles) used[t[0]] = used[t[1]] = used[t[2]] = true;
  const auto loose = std::count(used.begin(), used.end(), false);
  if (loose > 0) fmt::format_to(out, "VERTICES {} {}\n", loose, 2 * loose);
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) fmt::format_to(out, "1 {}\n", i);
  }
  // In ASCII files these are fractions of one.
  fmt::format_to(out, "POINT_DATA {}\nCOLOR_SCALARS RGB 3\n", mesh.colors.size());
  for (const Color& c : mesh.colors)
    fmt::format_to(out, "{:.4f} {:.4f} {:.4f}\n", c[0] / 255.0, c[1] / 255.0, c[2] / 255.0);
  return text;
}

std::string toPly(const ColorMesh& mesh) {
  std::string text = "ply\nformat ascii 1.0\ncomment xview\n";
  auto out = std::back_inserter(text);
  fmt::format_to(out,
                 "element vertex {}\nproperty double x\nproperty double y\nproperty double z\n"
                 "property uchar red\nproperty uchar green\nproperty uchar blue\n"
                 "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
                 mesh.vertices.size(), mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Eigen::Vector3d& p = mesh.vertices[i];
    const Color& c = mesh.colors[i];
    fmt::format_to(out, "{:.3f} {:.3f} {:.3f} {} {} {}\n", p.x(), p.y(), p.z(), c[0], c[1], c[2]);
  }
  for (const auto& t : mesh.triangles) fmt::format_to(out, "3 {} {} {}\n", t[0], t[1], t[2]);
  return text;
}

double typicalVertexRadius(const SemanticGraph& graph) {
  std::vector<double> lengths;
  for (const auto& [i, j] : graph.edges()) {
    const double length = (graph.vertices[i].position - graph.vertices[j].position).norm();
    if (std::isfinite(length)) lengths.push_back(length);
  }
  if (lengths.empty()) return 0.6;
  return std::clamp(kShareOfEdge * medianOf(std::move(lengths)), kSmallest_m, kLargest_m);
}

void addGraph(ColorMesh& mesh, const SemanticGraph& graph, const LabelSet& labels,
              double vertex_radius_m, const Color& edge_color,
              const Eigen::Isometry3d& T_scene_graph) {
  for (const Vertex& v : graph.vertices) {
    if (!v.position.allFinite()) continue;
    const bool is_surface = labels.role(v.label) == Role::surface;
    addOctahedron(mesh, T_scene_graph * v.position,
                  is_surface ? vertex_radius_m / 2 : vertex_radius_m, labels.color(v.label));
  }
  for (const auto& [i, j] : readableEdges(graph)) {
    addTube(mesh, T_scene_graph * graph.vertices[i].position,
            T_scene_graph * graph.vertices[j].position, vertex_radius_m / 8, edge_color);
  }
}

}  // namespace xview
