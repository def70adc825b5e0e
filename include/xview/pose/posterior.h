// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <string>
#include <vector>

#include "xview/types/localization.h"
#include "xview/types/option_field.h"

namespace xview::pose {

struct PosteriorOptions {
  bool enabled = true;
  std::string solver = "trust_region";
  std::string gravity = "auto";
  double odometry_sigma_m = 0.05;
  double odometry_sigma_rad = 0.002;

  /// What a caller may know better than this, but a user need not.
  struct Model {
    double vertex_sigma_m = 0.1;      ///< of an observed vertex, beside what its graph says
    double match_sigma_m = 0.3;       ///< of a vertex to its partner, beside the error of the map
    double gravity_sigma_rad = 0.01;  ///< of the known up
    /// Of trust_region: matches further apart than this many standard deviations count less
    /// (Cauchy); 0 = quadratic.
    double robust_scale = 2;
    /// Longer windows are thinned to about this number of poses, which odometry then interpolates.
    int max_poses = 60;
  } model;
};

template <class Visitor>
void visit(PosteriorOptions& o, Visitor&& field) {
  field("enabled", o.enabled,
        "correct the pose by the matched vertices and the odometry of the window");
  field(
      "solver", o.solver, Choices{{"trust_region", "gauss_newton"}},
      "trust_region: from the given pose, robust; gauss_newton: as in the paper, quadratic costs, "
      "from the mean of the matched map vertices");
  field(
      "gravity", o.gravity, Choices{{"auto", "aligned", "free"}},
      "aligned: up is known in query and map; free: it is not; auto: aligned if the given pose is "
      "upright within 5 degrees");
  field("odometry_sigma_m", o.odometry_sigma_m, Range{1e-6, 1e3},
        "odometry error after one metre; grows with the root of the distance [m]");
  field("odometry_sigma_rad", o.odometry_sigma_rad, Range{1e-8, 10},
        "same for the direction [rad]");
}

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
