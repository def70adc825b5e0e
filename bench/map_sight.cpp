// SPDX-License-Identifier: BSD-3-Clause
#include "map_sight.h"

#include <algorithm>
#include <cmath>

namespace xview::bench {
namespace {

constexpr double kFarthest_m = 25;  ///< as mapping believes in thin things
constexpr double kNearest_m = 0.5;
constexpr double kBehind_m = 0.5, kBehindShare = 0.05;  ///< depths are no better known

bool seesFreely(const Frame& frame, const Eigen::Vector3d& p) {
  const Eigen::Vector3d q = frame.T_odom_sensor.inverse() * p;
  if (q.z() < kNearest_m || q.norm() > kFarthest_m) return false;
  const int u = static_cast<int>(std::lround(frame.camera.fx * q.x() / q.z() + frame.camera.cx));
  const int v = static_cast<int>(std::lround(frame.camera.fy * q.y() / q.z() + frame.camera.cy));
  if (u < 0 || v < 0 || u >= frame.depth.width || v >= frame.depth.height) return false;
  const double measured = frame.depth.at(u, v);
  const double expected = frame.camera.depth_is_range ? q.norm() : q.z();
  return measured <= 0 || measured >= expected - std::max(kBehind_m, kBehindShare * expected);
}

}  // namespace

MapSight::MapSight(const FrameSource& source) {
  if (source.sensor() != Sensor::camera) return;
  for (std::size_t i = 0; i < source.size(); ++i) frames_.push_back(source.read(i));
}

bool MapSight::contains(const Eigen::Vector3d& p) const {
  const auto sees = [&](const Frame& frame) {
    int free = 0;
    for (const double height_m : {0.7, 1.3, 1.9})
      free += seesFreely(frame, p + Eigen::Vector3d(0, 0, height_m));
    return free >= 2;
  };
  return frames_.empty() || std::any_of(frames_.begin(), frames_.end(), sees);
}

}  // namespace xview::bench
