// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "xview/types/place.h"
#include "xview/types/pose.h"

namespace xview {

/// The plane part of a gravity-aligned pose.
inline PlacePose placeOf(const Eigen::Isometry3d& T) {
  return {T.translation().x(), T.translation().y(), yawOf(T.linear()), 0};
}

/// The gravity-aligned pose that heads the same way and puts a point of the query in the same
/// place.
inline Eigen::Isometry3d alignedAbout(const Eigen::Vector3d& point, const Eigen::Isometry3d& T) {
  Eigen::Isometry3d aligned = poseFromYaw(Eigen::Vector3d::Zero(), yawOf(T.linear()));
  aligned.translation() = T * point - aligned.linear() * point;
  return aligned;
}

/// Where a pose puts a point of the query. Query frames begin anywhere, so poses of their origins
/// cannot be compared.
inline PlacePose placeOfPoint(const PlacePose& pose, const Eigen::Vector2d& point) {
  const Eigen::Vector2d p = Eigen::Rotation2Dd(pose.yaw) * point + Eigen::Vector2d(pose.x, pose.y);
  return {p.x(), p.y(), pose.yaw, pose.score};
}

/// True if a place cannot be the other one a little further down the same street.
inline bool isFar(const PlacePose& a, const PlacePose& b) {
  constexpr double kFar_m = 20, kFar_rad = 0.8;
  return std::hypot(a.x - b.x, a.y - b.y) > kFar_m ||
         std::abs(angleDifference(a.yaw, b.yaw)) > kFar_rad;
}

}  // namespace xview
