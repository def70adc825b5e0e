// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <vector>

#include "xview/types/localization.h"

namespace xview {

using Vector6d = Eigen::Matrix<double, 6, 1>;

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

  std::size_t knots() const { return knots_; }  ///< beside the last pose
  Eigen::Index size() const { return static_cast<Eigen::Index>(6 * knots_); }

  /// Where a pose is: its error is (1 - share) of that of `knot` and `share` of that of the next
  /// one. Knot 0 is the last pose.
  struct Place {
    std::size_t knot = 0;
    double share = 0;
  };
  const Place& placeOf(std::size_t pose) const { return places_[pose]; }
  /// `errors`: those of the knots but the last pose, nearest first.
  Vector6d at(const Place& place, const Eigen::VectorXd& errors) const;

  /// Inverse covariance of the errors, before anything was seen.
  const Eigen::MatrixXd& information() const { return information_; }
  /// What errors along x y z or about x y z add to it.
  Eigen::MatrixXd informationOf(Eigen::Index axis) const;

 private:
  std::size_t knots_ = 0;
  std::vector<Place> places_;
  Eigen::MatrixXd of_pieces_;                   ///< inverse covariance of pieces in one axis
  std::array<Eigen::MatrixXd, 6> differences_;  ///< errors of pieces over their rates, by axis
  Eigen::MatrixXd information_;
};

}  // namespace xview
