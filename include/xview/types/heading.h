// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "xview/types/frame.h"

namespace xview {

/// Where a sensor with this attitude in the map looks in the plane, counter-clockwise from x [rad]:
/// cameras along z, everything else along x. For a camera that looks straight down it is what the
/// top of its image shows.
double headingOf(const Eigen::Matrix3d& R_map_sensor, Sensor sensor);

}  // namespace xview
