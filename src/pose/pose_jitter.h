// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "drift_chain.h"
#include "xview/types/localization.h"

namespace xview {

/// How the points of one pose pull at it, about its own sensor: x y z, rx ry rz in the map frame.
struct PosePull {
  Matrix6d information = Matrix6d::Zero();
  Vector6d pull = Vector6d::Zero();
  Matrix6d of_blocks = Matrix6d::Zero();  ///< squares of the pulls of blocks of points, summed
  int blocks = 0;
};

/// Variances by which poses err each on its own: of x and y, z, tilt, and yaw [m^2, rad^2]. Found
/// from how much further the points of a pose pull together than blocks of them that err each on
/// its own would; 0 where they do not. Poses of few blocks do not count.
Vector6d poseJitter(const std::vector<PosePull>& poses);

}  // namespace xview
