// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "search/bev_town.h"
#include "xview/localizer.h"

namespace xview::test {

inline constexpr double kReach_m = 22;  ///< what a window sees around its middle

/// Two parallel streets along x, 200 m apart. The second half of one is a copy of that of the
/// other; with `all`, so is the first.
inline BevTown twoStreets(bool all) {
  BevTown town;
  Random a(3), b(all ? 3u : 4u), c(7), d(7);
  town.street(-150, 0, 0, a);
  town.street(-150, 0, 200, b);
  town.street(0, 150, 0, c);
  town.street(0, 150, 200, d);
  return town;
}

inline map::SemanticMap mapOf(const BevTown& town) {
  map::SemanticMap map;
  map.bev = town.view({0, 100}, 260, Eigen::Isometry3d::Identity());
  for (const double y : {0.0, 200.0}) {
    for (double x = -150; x <= 150; x += 5) {
      map.poses.emplace_back(Eigen::Translation3d(x, y, 1.5));
    }
  }
  return map;
}

/// A robot at (x, y) of a town that looks along the street, in the frame of its odometry.
inline Query queryAt(const BevTown& town, double x, double y,
                     const Eigen::Isometry3d& T_town_odom) {
  Query query;
  query.bev = town.view({x, y}, kReach_m, T_town_odom.inverse());
  query.sensor = Sensor::lidar;
  Eigen::Isometry3d sensor = Eigen::Isometry3d::Identity();
  sensor.translation() = Eigen::Vector3d(x, y, BevTown::groundHeight(x, y) + 1.5);
  query.poses = {T_town_odom.inverse() * sensor};
  return query;
}

inline double errorOf(const Localization& fix, double x, double y) {
  return std::hypot(fix.T_map_sensor.translation().x() - x, fix.T_map_sensor.translation().y() - y);
}

}  // namespace xview::test
