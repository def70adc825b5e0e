// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <limits>

namespace xview {

/// Pinhole camera; pixel (u, v) looks along ((u - cx) / fx, (v - cy) / fy, 1): x right, y down, z
/// forward.
struct Camera {
  int width = 0;
  int height = 0;
  double fx = 0, fy = 0;        ///< pixels
  double cx = 0, cy = 0;        ///< pixels
  double depth_scale = 1;       ///< metres per unit of an integer depth image
  bool depth_is_range = false;  ///< depth along the ray instead of along the optical axis
  double min_range_m = 0;       ///< what this camera measures nearer, or further, is not believed;
  double max_range_m = std::numeric_limits<double>::infinity();  ///< beside the limits of lifting

  /// p_sensor of a pixel of that depth.
  Eigen::Vector3d unproject(double u, double v, double depth) const {
    const Eigen::Vector3d ray((u - cx) / fx, (v - cy) / fy, 1);
    return depth_is_range ? Eigen::Vector3d(ray.normalized() * depth)
                          : Eigen::Vector3d(ray * depth);
  }
};

}  // namespace xview
