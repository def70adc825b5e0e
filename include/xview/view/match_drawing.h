// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "xview/types/correspondence.h"
#include "xview/types/graph.h"
#include "xview/types/labels.h"
#include "xview/view/color_mesh.h"

namespace xview {

struct MatchDrawingStyle {
  double lift_m =
      0;  ///< height of the query above the map; 0: a third of the query's width, at least 10 m
  double reach_m =
      0;  ///< map vertices farther from the query are left out unless matched; 0: all of them
  std::size_t most_putative = 400;  ///< of putative correspondences drawn, evenly thinned
  Color kept_color{30, 170, 60};
  Color putative_color{214, 150, 150};
};

/// The figure of a match: the map graph on the ground, the query graph at its estimated pose but
/// lifted, and a line per correspondence: green if it was kept, pale red if it was only putative.
/// Indices out of range are left out.
ColorMesh drawMatches(const SemanticGraph& map, const SemanticGraph& query, const LabelSet& labels,
                      const Eigen::Isometry3d& T_map_query,
                      const std::vector<Correspondence>& putative,
                      const std::vector<Correspondence>& kept, const MatchDrawingStyle& style = {});

}  // namespace xview
