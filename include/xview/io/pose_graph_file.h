// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <string>
#include <vector>

#include "xview/types/localization.h"

namespace xview {

/// Poses with what is known between them, as solvers of pose graphs take it.
struct PoseGraph {
  /// The pose of `to` seen from `from`. `covariance` is that of Localization: x y z [m], rx ry rz
  /// [rad] of `to`, in the axes of `from`, left increment (t_true = t + d, R_true = exp(w^) R).
  struct Edge {
    std::size_t from = 0, to = 0;  ///< indices into poses
    Eigen::Isometry3d T_from_to = Eigen::Isometry3d::Identity();
    Matrix6d covariance = Matrix6d::Identity();
  };
  std::vector<Eigen::Isometry3d> poses;
  std::vector<std::size_t> fixed;  ///< poses that a solver must not move
  std::vector<Edge> edges;
};

/// VERTEX_SE3:QUAT, FIX and EDGE_SE3:QUAT lines of g2o; ids are the indices. The information of an
/// edge is what g2o expects: the upper triangle, row by row, for the translation in the axes of
/// `to` and the vector part of the unit quaternion, which is half the angle. Covariances that
/// cannot be inverted are widened until they can (1 mm, 1e-4 rad). Appears whole or not at all.
/// Throws std::out_of_range if an index is no pose.
void writePoseGraph(const std::string& path, const PoseGraph& graph);

}  // namespace xview
