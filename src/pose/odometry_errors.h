// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "xview/base/localization.h"

namespace xview::pose {

using Vector6d = Eigen::Matrix<double, 6, 1>;

// How far the odometry of a window is off: by drift, which poses share, and by jitter, which they
// do not.

/// L with L w = w x v, as the derivative of a point v under a rotation vector is.
Eigen::Matrix3d crossFromRight(const Eigen::Vector3d& v);

/// How far the odometry of a window is off, against its last pose: an error (t [m], w [rad]) at
/// knots along the way, linear in between, zero at the last pose. About the last sensor, in the map
/// frame: what was seen from there moves by t + w x lever.
///
/// The error of a piece of way is a length and a turn per metre. Their variance is mostly one that
/// keeps its value over a long way, as a wrong scale does; the rest is a random walk.
class DriftChain {
 public:
  struct Rates {
    double share = 0;       ///< of the way; 0 = no drift at all
    double turn_per_m = 0;  ///< [rad/m]
  };

  /// `ways_m`: from each pose to the last one; poses beyond `reach_m` err like the one there.
  /// `sensors`: positions of the poses about that of the last one, axes of the map.
  DriftChain(const std::vector<double>& ways_m, const std::vector<Eigen::Vector3d>& sensors,
             double reach_m, const Rates& rates);

  Eigen::Index size() const { return information_.rows(); }  ///< 6 per knot; 0: no drift

  /// Of a pose in the error of a knot, whose six numbers begin at `row` among those of all knots
  /// but the last pose, nearest first.
  struct Share {
    Eigen::Index row;
    double share;
  };
  /// At most two; none where there is no drift.
  const std::vector<Share>& sharesOf(std::size_t pose) const { return shares_[pose]; }
  Vector6d errorOf(std::size_t pose, const Eigen::VectorXd& errors) const;

  /// Inverse covariance of the errors, before anything was seen.
  const Eigen::MatrixXd& information() const { return information_; }
  /// What errors along x y z or about x y z add to it.
  Eigen::MatrixXd informationOf(Eigen::Index axis) const;

 private:
  std::vector<std::vector<Share>> shares_;      ///< by pose
  Eigen::MatrixXd of_pieces_;                   ///< inverse covariance of pieces in one axis
  std::array<Eigen::MatrixXd, 6> differences_;  ///< errors of pieces over their rates, by axis
  Eigen::MatrixXd information_;
};

/// How the points of one pose pull at it, about its own sensor: x y z, rx ry rz in the map frame.
struct PosePull {
  Matrix6d information = Matrix6d::Zero();
  Vector6d pull = Vector6d::Zero();
  Matrix6d of_blocks = Matrix6d::Zero();  ///< squares of the pulls of blocks of points, summed
  int blocks = 0;
};

/// Variances by which poses err each on its own: of x and y, z, tilt, and yaw [m^2, rad^2]. Found
/// from how much further the points of a pose pull together than blocks of them that err each on
/// its own would; 0 where they do not. Poses of few blocks do not count.
Vector6d poseJitter(const std::vector<PosePull>& poses);

}  // namespace xview::pose
