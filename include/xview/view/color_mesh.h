// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "xview/types/graph.h"
#include "xview/types/labels.h"

namespace xview {

using Color = std::array<std::uint8_t, 3>;  ///< red, green, blue

/// A coloured triangle mesh: what every viewer shows alike, unlike lines and big points. A vertex
/// that no triangle uses is a point of a cloud.
struct ColorMesh {
  std::vector<Eigen::Vector3d> vertices;  ///< [m]
  std::vector<Color> colors;              ///< one per vertex
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// Eight triangles around a point.
void addOctahedron(ColorMesh& mesh, const Eigen::Vector3d& center, double radius_m,
                   const Color& color);

/// A tube with three sides, open at its ends. Nothing if both ends are the same point.
void addTube(ColorMesh& mesh, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
             double radius_m, const Color& color);

/// Legacy ASCII VTK: POLYGONS, and VERTICES for what no triangle uses, with COLOR_SCALARS, for
/// `pcl_viewer cloud.pcd mesh.vtk`. Coordinates in millimetres' precision.
std::string toVtk(const ColorMesh& mesh);

/// ASCII PLY mesh with red green blue per vertex, for MeshLab, CloudCompare and the like.
std::string toPly(const ColorMesh& mesh);

/// Of the octahedra of a graph, from the typical length of its edges: 0.15 to 3 m.
double typicalVertexRadius(const SemanticGraph& graph);

/// Adds an octahedron per vertex in the colour of its class, of half the size for surface classes,
/// and a tube per edge; of graphs with more than six edges per vertex only the shortest edges. The
/// graph is moved by T_scene_graph. Vertices that are not finite are left out.
void addGraph(ColorMesh& mesh, const SemanticGraph& graph, const LabelSet& labels,
              double vertex_radius_m, const Color& edge_color,
              const Eigen::Isometry3d& T_scene_graph = Eigen::Isometry3d::Identity());

}  // namespace xview
