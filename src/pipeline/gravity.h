// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "xview/mapper.h"
#include "xview/types/localization.h"

namespace xview {

/// The rotation that makes z point up. Identity if the frame is gravity-aligned within 15 degrees, as odometry frames mostly are; poses
/// relative to a first camera are not. Up is the normal of the ground classes under each sensor, on the side of the sensor; without
/// ground it is what cameras near the ground call up.
Eigen::Quaterniond uprightRotation(const FrameDigest* first, const FrameDigest* last, const LabelSet& labels);

}  // namespace xview
