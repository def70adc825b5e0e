// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

namespace xview::pose {

struct Alignment {
  bool valid = false;
  std::string problem;  ///< why not valid: too few points, collinear, …
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();
  double rms_m = 0;  ///< of what is left
};

/// Least-squares rigid transform (Umeyama 1991 without scale), in double,
/// min sum |target - T source|^2; never a reflection. Not valid: fewer than 3 points, points that
/// coincide or lie on one line (spread across it below a thousandth of the spread along), a source
/// that fits only as the mirror image in several ways, positions that are not finite.
Alignment alignPoints(const std::vector<Eigen::Vector3d>& source,
                      const std::vector<Eigen::Vector3d>& target);

/// Same with rotation about z only (both frames gravity-aligned): x, y, z and yaw; needs 2 points
/// apart in the plane.
Alignment alignPointsInYaw(const std::vector<Eigen::Vector3d>& source,
                           const std::vector<Eigen::Vector3d>& target);

}  // namespace xview::pose
