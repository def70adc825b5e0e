// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "sim/town.h"

namespace xview {

/// The middle of streets one after the other, longer than this and without turning round; prefers
/// streets it has not seen.
Polyline streetsThrough(const StreetNetwork& network, double length_m, std::uint64_t seed);

/// Such a drive of this length. Points about 1 m apart, corners rounded so that lanes on both sides
/// stay on the road.
Polyline planDrive(const StreetNetwork& network, double length_m, std::uint64_t seed);

/// The line `left_m` to the left of a drive (negative: right).
Polyline shifted(const Polyline& drive, double left_m);

Polyline reversed(Polyline drive);

/// How a sensor sits on the vehicle or in the air.
struct Mount {
  double height_m = 1.7;    ///< above the ground
  double yaw_rad = 0;       ///< against the direction of travel, positive to the left
  double pitch_rad = 0;     ///< positive looks down
  double sway_rad = 0.004;  ///< amplitude of slow roll and pitch
  bool follows_slope = true;
  double rise_m = 0;  ///< amplitude of slow changes of height
};

/// Poses of a body (x forward, y left, z up) every `spacing_m` along the line.
std::vector<Eigen::Isometry3d> bodyPoses(const Polyline& line, double spacing_m, const Mount& mount,
                                         const Relief& relief, std::uint64_t seed);

/// The sensor of somebody who walks through these poses on a floor, `left_m` beside the middle.
std::vector<Eigen::Isometry3d> carriedPoses(std::vector<Eigen::Isometry3d> T_world_body,
                                            const Mount& mount, double left_m, std::uint64_t seed);

/// Optical frame (x right, y down, z forward) of a camera that looks along x of the body.
Eigen::Isometry3d opticalPose(const Eigen::Isometry3d& T_world_body);

/// The same poses as an odometry would give them: in an upright frame of its own with any yaw and
/// origin, with an error that grows to about `drift` (0.01 = 1 %) of the distance travelled. Roll
/// and pitch stay right: gravity is known.
std::vector<Eigen::Isometry3d> asOdometry(const std::vector<Eigen::Isometry3d>& T_world_sensor,
                                          double drift, std::uint64_t seed);

}  // namespace xview
