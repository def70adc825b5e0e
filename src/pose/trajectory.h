// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <optional>
#include <vector>

#include "xview/base/localization.h"

namespace xview::pose {

/// A pose of a recording that was found in the map.
struct TrajectoryFix {
  std::size_t index = 0;  ///< position of the pose in the recording
  /// Takes points of the odometry frame, times `scale`, to the map.
  Eigen::Isometry3d T_map_query = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_map_sensor = Eigen::Isometry3d::Identity();
  double scale = 1;
  Matrix6d covariance = Matrix6d::Zero();  ///< of T_map_sensor, as in Localization
  double confidence = 0;
  /// T_map_sensor of the frames up to this one, the last of them, as they were found together; may
  /// be empty.
  std::vector<Eigen::Isometry3d> way;
};

/// What an answer says of the frame of the recording that was the last one of its query.
TrajectoryFix fixOf(const Localization& answer, std::size_t index);

/// How far the second fix is from where the odometry leads from the first [m].
double offBetween(const TrajectoryFix& a, const TrajectoryFix& b,
                  const std::vector<Eigen::Isometry3d>& T_odom_sensor);

/// Of the distance between two fixes, by their covariances [m].
double sigmaBetween(const TrajectoryFix& a, const TrajectoryFix& b);

/// The frames of a recording whose poses the odometry tells from fixes, which are in its order:
/// those within 10 m of the way of one, and those between two, 25 m or more apart, of which the
/// odometry errs by at most 5 % of the way; none between two of which it errs by more. Windows that
/// were found together are bent by as much as it errs, so that being part of one says little.
/// `way_m`: of each frame (pathLengths); `size`: of the place, by which these lengths are scaled.
std::vector<bool> toldByOdometry(const std::vector<TrajectoryFix>& fixes,
                                 const std::vector<Eigen::Isometry3d>& T_odom_sensor,
                                 const std::vector<double>& way_m, double size);

/// All poses of a recording in the map frame, T_map_sensor. Frames that were found together lie as
/// they were found; between two fixes what they say of a frame is weighed by its distance along the
/// way, before the first and after the last one odometry goes on from there, its lengths multiplied
/// by what they are on the ways that were found. Fixes are in the order of the recording, at least
/// one.
std::vector<Eigen::Isometry3d> trajectoryThrough(
    const std::vector<Eigen::Isometry3d>& T_odom_sensor, const std::vector<TrajectoryFix>& fixes);

/// The same where the odometry jumps: no fix says anything of a frame on the other side of a jump.
/// `jumps`: positions of the frames behind them, in order. Nothing for the frames of a stretch
/// without a fix.
std::vector<std::optional<Eigen::Isometry3d>> trajectoryThrough(
    const std::vector<Eigen::Isometry3d>& T_odom_sensor, const std::vector<TrajectoryFix>& fixes,
    const std::vector<std::size_t>& jumps);

/// The covariance of a pose, if that of a pose with position `p_map` is `covariance`; both are
/// moved by the same left increments (x y z rx ry rz, map frame).
Matrix6d movedCovariance(const Matrix6d& covariance, const Eigen::Vector3d& p_map,
                         const Eigen::Vector3d& to_map);

}  // namespace xview::pose
