// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "xview/types/graph.h"
#include "xview/types/labels.h"
#include "xview/view/color_mesh.h"

namespace xview {

struct GraphMeshStyle {
  double vertex_radius_m = 0;  ///< 0: from the typical length of the edges, 0.15 to 3 m
  double tube_radius_m = 0;    ///< 0: an eighth of the vertex radius
  Color edge_color{150, 150, 150};
  std::optional<Color> vertex_color;  ///< none: the colour of the class
};

/// The radius that is used when the style leaves it open.
double typicalVertexRadius(const SemanticGraph& graph);

/// An octahedron per vertex, of half the size for surface classes, and a tube per edge; of graphs
/// with more than six edges per vertex only the shortest edges. The graph is moved by
/// T_scene_graph. Vertices that are not finite are left out.
ColorMesh graphMesh(const SemanticGraph& graph, const LabelSet& labels,
                    const GraphMeshStyle& style = {},
                    const Eigen::Isometry3d& T_scene_graph = Eigen::Isometry3d::Identity());

/// Appends one mesh to another.
void append(ColorMesh& mesh, const ColorMesh& addition);

}  // namespace xview
