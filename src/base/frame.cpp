// SPDX-License-Identifier: BSD-3-Clause
#include "xview/base/frame.h"

#include <cmath>

namespace xview {

double headingOf(const Eigen::Matrix3d& R_map_sensor, Sensor sensor) {
  constexpr double kStraightDown = 0.98;
  const bool is_camera = sensor == Sensor::camera;
  Eigen::Vector3d forward = R_map_sensor.col(is_camera ? 2 : 0);
  if (is_camera && std::abs(forward.z()) > kStraightDown) forward = -R_map_sensor.col(1);
  return std::atan2(forward.y(), forward.x());
}

}  // namespace xview
