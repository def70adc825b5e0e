// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

namespace xview::pose {

// The constraints of the posterior (paper, section III-F), as functors for automatic
// differentiation.
//
// A pose is an array of 7: x y z [m], qx qy qz qw (Eigen's order of a unit quaternion), of
// T_map_sensor. A vertex is an array of 3: x y z [m] in the map frame. Every residual is divided by
// its standard deviation, so that half the squared norm is a negative log-likelihood.

template <class T>
Eigen::Map<const Eigen::Matrix<T, 3, 1>> positionOf(const T* pose) {
  return Eigen::Map<const Eigen::Matrix<T, 3, 1>>(pose);
}

template <class T>
Eigen::Map<const Eigen::Quaternion<T>> rotationOf(const T* pose) {
  return Eigen::Map<const Eigen::Quaternion<T>>(pose + 3);
}

/// Odometry between two poses a and b, measured as T_a_b:
///   r[0..2] = (R_a^T (t_b - t_a) - t_a_b) / sigma_m                 in the frame of a
///   r[3..5] = 2 vec(q_a_b^-1 q_a^-1 q_b) / sigma_rad                in the frame of b
struct OdometryResidual {
  Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();
  double sigma_m = 1;
  double sigma_rad = 1;

  template <class T>
  bool operator()(const T* pose_a, const T* pose_b, T* residuals) const {
    const Eigen::Quaternion<T> to_a = rotationOf(pose_a).conjugate();
    const Eigen::Quaternion<T> measured(Eigen::Quaternion<double>(T_a_b.linear()).cast<T>());
    Eigen::Quaternion<T> error = measured.conjugate() * (to_a * rotationOf(pose_b));
    if (error.w() < T(0)) error.coeffs() = -error.coeffs();  // the shorter way round
    const Eigen::Matrix<T, 3, 1> b_in_a = to_a * (positionOf(pose_b) - positionOf(pose_a));
    Eigen::Map<Eigen::Matrix<T, 6, 1>> r(residuals);
    r.template head<3>() = (b_in_a - T_a_b.translation().cast<T>()) / T(sigma_m);
    r.template tail<3>() = T(2) * error.vec() / T(sigma_rad);
    return true;
  }
};

/// A vertex p (map frame) that a pose saw at p_sensor (its own frame):
///   r = (R^T (p - t) - p_sensor) / sigma_m
struct ObservationResidual {
  Eigen::Vector3d p_sensor = Eigen::Vector3d::Zero();
  double sigma_m = 1;

  template <class T>
  bool operator()(const T* pose, const T* vertex, T* residuals) const {
    const Eigen::Matrix<T, 3, 1> seen =
        rotationOf(pose).conjugate() * (positionOf(vertex) - positionOf(pose));
    Eigen::Map<Eigen::Matrix<T, 3, 1>> r(residuals);
    r = (seen - p_sensor.cast<T>()) / T(sigma_m);
    return true;
  }
};

/// A vertex p that is the map's vertex at p_map, known with covariance C = L L^T:
///   r = L^-1 (p - p_map)
struct MatchResidual {
  Eigen::Vector3d p_map = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inverse_L = Eigen::Matrix3d::Identity();

  template <class T>
  bool operator()(const T* vertex, T* residuals) const {
    Eigen::Map<Eigen::Matrix<T, 3, 1>> r(residuals);
    r = inverse_L.cast<T>() * (positionOf(vertex) - p_map.cast<T>());
    return true;
  }
};

/// The odometry knows which way is up (up_sensor, a unit vector in the sensor frame), and the map's
/// z axis points up:
///   r = first two of R up_sensor, / sigma_rad
struct GravityResidual {
  Eigen::Vector3d up_sensor = Eigen::Vector3d::UnitZ();
  double sigma_rad = 1;

  template <class T>
  bool operator()(const T* pose, T* residuals) const {
    const Eigen::Matrix<T, 3, 1> up = rotationOf(pose) * up_sensor.cast<T>();
    residuals[0] = up[0] / T(sigma_rad);
    residuals[1] = up[1] / T(sigma_rad);
    return true;
  }
};

}  // namespace xview::pose
