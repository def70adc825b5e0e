// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <string>
#include <vector>

#include "xview/base/localization.h"
#include "xview/options.h"

namespace xview::pose {

/// A vertex of the query that has a partner in the map.
struct MatchedVertex {
  Eigen::Vector3d p_odom = Eigen::Vector3d::Zero();  ///< as the query graph has it
  double sigma_m = 0;                                ///< of it, per axis; 0 = unknown
  std::size_t first_pose = 0, last_pose = 0;  ///< the poses of the window that saw it, inclusive
  Eigen::Vector3d p_map = Eigen::Vector3d::Zero();           ///< its partner
  Eigen::Matrix3d map_covariance = Eigen::Matrix3d::Zero();  ///< of the partner [m^2]
};

struct Posterior {
  bool converged = false;                       ///< other fields are valid only if true
  std::string problem;                          ///< why not converged
  std::vector<Eigen::Isometry3d> T_map_sensor;  ///< one per pose of the window
  /// Of the last pose: x y z [m], rx ry rz [rad] in the map frame. Its error is the left increment
  /// (d, w): t_true = t + d, R_true = exp(w^) R.
  Matrix6d covariance = Matrix6d::Zero();
  double cost_before = 0;  ///< half the sum of squared residuals (after the loss) at the start
  double cost_after = 0;
  int iterations = 0;
};

/// The paper's back-end (section III-F): the robot poses c_i and the vertices p_j that are most
/// probable given odometry between poses, observation of each vertex from the nearest pose that saw
/// it, and the map positions of the matches (Eq. 3: sum of e^T Omega e). `T_odom_sensor` is the
/// window, `T_map_query` the start of trust_region.
///
/// gauss_newton starts where the paper does: with the last pose at the mean of the matched map
/// vertices and the axes of odometry and map parallel; it takes full steps on quadratic costs. With
/// right matches it reaches the optimum of trust_region from any heading in 4 to 15 iterations; a
/// wrong match pulls with its full weight.
///
/// Not converged: no or not finite input, matches that leave the last pose open (fewer than 3, or
/// on one line without gravity), or a gauss_newton that does not converge. A trust_region that runs
/// out of iterations gives the best so far.
Posterior maximizePosterior(const std::vector<Eigen::Isometry3d>& T_odom_sensor,
                            const std::vector<MatchedVertex>& vertices,
                            const Eigen::Isometry3d& T_map_query, const PosteriorOptions& options);

}  // namespace xview::pose
