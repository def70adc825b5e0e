// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "xview/sim/mesh.h"

namespace xview {

enum class TreeShape { round, columnar, conifer, spreading };

struct TreeDesign {
  TreeShape shape = TreeShape::round;
  double height_m = 7;
  double crown_radius_m = 2;
  double trunk_m = 2;  ///< height of the lowest leaves
};

TreeDesign drawTree(Random& random);

/// Trunk and crown, standing at `base`.
void addTree(TriangleMesh& mesh, const Eigen::Vector3d& base, const TreeDesign& design,
             Random& random, Tag tag);

void addBush(TriangleMesh& mesh, const Eigen::Vector3d& base, double radius_m, Random& random,
             Tag tag);

}  // namespace xview
