// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "xview/types/correspondence.h"
#include "xview/types/graph.h"
#include "xview/types/labels.h"

namespace xview {

using Color = std::array<std::uint8_t, 3>;  ///< red, green, blue

/// A coloured triangle mesh: what every viewer shows alike, unlike lines and big points.
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

/// Legacy ASCII VTK: POLYGONS with COLOR_SCALARS, for `pcl_viewer cloud.pcd mesh.vtk`. Coordinates
/// in millimetres' precision.
std::string toVtk(const ColorMesh& mesh);

/// ASCII PLY mesh with red green blue per vertex, for MeshLab, CloudCompare and the like.
std::string toPly(const ColorMesh& mesh);

/// Of the octahedra of a graph, from the typical length of its edges: 0.15 to 3 m.
double typicalVertexRadius(const SemanticGraph& graph);

/// An octahedron per vertex in the colour of its class, of half the size for surface classes, and a
/// tube per edge; of graphs with more than six edges per vertex only the shortest edges. The graph
/// is moved by T_scene_graph. Vertices that are not finite are left out.
ColorMesh graphMesh(const SemanticGraph& graph, const LabelSet& labels,
                    const Eigen::Isometry3d& T_scene_graph = Eigen::Isometry3d::Identity());

constexpr Color kKeptTubeColor{30, 170, 60}, kPutativeTubeColor{214, 150, 150};

/// The figure of a match: the map graph on the ground, the query graph at its estimated pose but
/// lifted by a third of its width, at least 10 m, and a line per correspondence: green if it was
/// kept, pale red if it was only putative. Indices out of range are left out.
ColorMesh drawMatches(const SemanticGraph& map, const SemanticGraph& query, const LabelSet& labels,
                      const Eigen::Isometry3d& T_map_query,
                      const std::vector<Correspondence>& putative,
                      const std::vector<Correspondence>& kept);

}  // namespace xview
