// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "inputs.h"
#include "xview/follower.h"

namespace xview::tools {

/// A frame as it comes.
struct LiveFrame {
  std::string input;  ///< what messages call it
  std::int64_t number = 0;
  std::optional<double> stamp_s;
  bool has_odometry = false;  ///< else every frame is a query of its own
  double sensor_off_m = 0;    ///< offFromSensor()
};

/// One JSON object on one line; pose, covariance and T_map_odom are null unless the robot is found.
/// `error`: why the frame could not be used.
std::string toJson(const LiveFrame& frame, const FollowAnswer& answer, double latency_ms,
                   const std::string& error = {});
/// What is said of a pose that jumped; empty if it did not.
std::string jumpText(const FollowAnswer& answer);

/// Adds what was read to those of a robot, and tells `about` how far off its points are.
/// `T_odom_sensor`: of the odometry, if it is not in the input. Throws Error if the input is no
/// frame, and as preprocessFrame().
FollowAnswer follow(Follower& follower, const QueryInput& input, LiveFrame& about,
                    const std::optional<Eigen::Isometry3d>& T_odom_sensor = {});

}  // namespace xview::tools
