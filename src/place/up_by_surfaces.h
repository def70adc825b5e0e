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

/// What is vertical in a cloud of a room, in its frame.
struct VerticalOfRoom {
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();  ///< a unit vector; zero if nothing tells
  bool is_up = false;                              ///< it points up, else up or down
};

/// By the same mixture, in a cloud of this scale (base/semantic_place.h): near z, or near y where
/// surfaces fit it clearly better, as in meshes; z itself if it is near enough. A cloud that lies
/// before its origin as a depth camera sees it (z forward, y down) has its up near -y. Nothing if
/// too few surfaces are seen.
VerticalOfRoom verticalOfRoom(const pcl::PointCloud<Point>& points, double size);

/// What may be vertical in a cloud instead of what is up as it was given.
struct OtherVertical {
  /// A unit vector, `up` if nothing else is; zero if too few surfaces are seen.
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();
  bool is_clear = false;  ///< that it is; else its ground must tell
  bool is_lean = false;   ///< within 45 degrees of `up`
};

/// By the same mixture, in a cloud of this scale of which little fits as if `up`, a unit vector in
/// its frame, were up: the direction within 45 degrees, or of all, that surfaces fit clearly
/// better.
OtherVertical otherVertical(const Eigen::Vector3d& up, double size,
                            const pcl::PointCloud<Point>& points);

}  // namespace xview
