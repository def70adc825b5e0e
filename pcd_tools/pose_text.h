// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "xview/io/pose_files.h"
#include "xview/io/recording.h"

namespace xview::tools {

/// What parseStampedPose() takes, for messages.
constexpr const char* kStampedPose =
    "stamp tx ty tz qx qy qz qw: finite numbers, within 1e8 m, with a quaternion of length 1";
/// "stamp tx ty tz qx qy qz qw" [s, m], as a line of TUM has it; nothing if the text is not eight
/// finite numbers with a position within 1e8 m and a quaternion of length 1.
std::optional<io::StampedPose> parseStampedPose(const std::string& text);

/// The flag of T_sensor_base.
constexpr const char* kSensorBaseFlag = "--T_sensor_base POSE";
constexpr const char* kSensorBaseHelp =
    "of the robot's base in the sensor frame: x,y,z,roll,pitch,yaw [m, deg] or a file of 4 x 4 "
    "numbers; --initialpose is then that of the base, as where the transforms of a bag say it";

/// T_sensor_base as "x,y,z,roll,pitch,yaw" [m, deg], or a file of 4 x 4 numbers; nothing if the
/// text is empty. Throws UsageError or Error.
std::optional<Eigen::Isometry3d> parseSensorBase(const std::string& text);
/// The same; if the text is empty, as a bag at `path` says.
std::optional<Eigen::Isometry3d> sensorBaseOf(const std::string& text, const std::string& path,
                                              const io::InputOptions& options);

}  // namespace xview::tools
