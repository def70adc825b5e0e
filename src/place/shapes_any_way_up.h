// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "xview/base/frame.h"
#include "xview/base/labelled_cloud.h"

namespace xview {

/// Gives points of a scan or a cloud the classes of their shapes (labelByShape) as they lie
/// when turned by R_up_sensor, in a place of this scale.
///
/// Where little lies as ground would, much is of no shape, or the ground leans, z may not be up:
/// meshes are often drawn with y up, cameras have y down, scanners hang, lean or lie on their
/// sides. Then, and in every cloud of a room, z is not up where it is not what surfaces say
/// (verticalOfRoom, otherVertical): returned is up as they say, a unit vector, else zero.
/// Where too few surfaces tell, labelled as of the way up by quarters that shows the most ground,
/// with things on it, if that is by far more.
Eigen::Vector3d labelAnyWayUp(const Eigen::Matrix3d& R_up_sensor, Sensor sensor, double size,
                              pcl::PointCloud<Point>& points);

/// Gives points the classes of their shapes as they lie when turned by R (labelByShape).
void labelTurned(const Eigen::Matrix3d& R, double size, pcl::PointCloud<Point>& points);

}  // namespace xview
