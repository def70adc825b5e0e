// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "xview/base/frame.h"
#include "xview/base/labelled_cloud.h"

namespace xview {

/// Up in the frame of the poses of a camera recording whose z is not up, as that of trackers that
/// begin in the frame of their first image; a unit vector. Zero if z may be up (images stand
/// upright by it, or the camera looks down from above), if the recording is of another sensor, or
/// if too few surfaces are seen. Up is near where images have their top, and most likely where
/// surfaces face it (floors, tables) or stand along it (walls): a mixture of both, of ceilings and
/// of any direction.
Eigen::Vector3d upOfCamera(const FrameSource& recording);

/// The axis that is vertical in a cloud of a room of this scale (base/semantic_place.h), by the
/// same mixture: near z, or near y where surfaces fit it clearly better, as in clouds of cameras. A
/// unit vector; whether it points up or down is not told. z itself if it is near enough, and where
/// too few surfaces are seen.
Eigen::Vector3d verticalOfRoom(const pcl::PointCloud<Point>& points, double size);

}  // namespace xview
