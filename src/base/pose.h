// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <vector>

namespace xview {

// Naming: T_target_source takes points of the source frame to the target frame,
//   p_target = T_target_source * p_source.

/// Yaw (rotation about z) of a rotation whose z axes roughly agree [rad, -pi..pi].
double yawOf(const Eigen::Matrix3d& R);

Eigen::Isometry3d poseOf(const Eigen::Matrix3d& R, const Eigen::Vector3d& position);
/// x, y, z and yaw as a transform that keeps z.
Eigen::Isometry3d poseFromYaw(const Eigen::Vector3d& position, double yaw_rad);

/// After this share of the path from one pose to another, straight and turning evenly.
Eigen::Isometry3d interpolated(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b,
                               double share);

/// Path length up to each of successive poses [m]; at least one number.
std::vector<double> pathLengths(const std::vector<Eigen::Isometry3d>& poses);

/// Angle of the rotation between two poses [rad, 0..pi].
double rotationBetween(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b);

/// a - b wrapped to [-pi, pi).
double angleDifference(double a_rad, double b_rad);

/// The closest proper rotation to a nearly orthonormal matrix.
Eigen::Matrix3d orthonormalized(const Eigen::Matrix3d& R);

/// True if the upper 3x3 block is a rotation within the tolerance and all is finite.
bool isRigid(const Eigen::Matrix4d& T, double tolerance = 1e-3);

}  // namespace xview
