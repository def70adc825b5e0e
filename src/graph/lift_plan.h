// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "xview/graph/lift.h"

namespace xview {

// A camera whose nearest tenth is further away than this looks down from the air.
constexpr float kAerialQuantile_m = 15;

/// Smallest and largest distance that is believed, squared.
struct Gate {
  float min2, max2;
  Gate(double min_m, double max_m)
      : min2(static_cast<float>(min_m * min_m)), max2(static_cast<float>(max_m * max_m)) {}
  bool holds(float range2) const { return range2 >= min2 && range2 <= max2; }
};

/// What is known of a frame before its points are looked at.
struct LiftPlan {
  Gate gate;
  Eigen::Vector3d origin;
  std::size_t expected;  ///< points, at most
};

/// Throws Error if images differ in size, focal lengths are not positive or the pose is not finite.
LiftPlan planOf(const Frame& frame, const LiftOptions& options);

/// Of a camera frame: the options and the camera itself; the stricter one counts.
double maxCameraRange(const Frame& frame, const LiftOptions& options);

}  // namespace xview
