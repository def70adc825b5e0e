// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

namespace xview {

struct Alignment {
  bool valid = false;
  std::string problem;  ///< why not valid: too few points, collinear, …
  Eigen::Isometry3d T_target_source = Eigen::Isometry3d::Identity();
  double rms_m = 0;     ///< weighted residual
};

/// Weighted least-squares rigid transform (Umeyama 1991 without scale), in double, sum w |target - T source|^2; never a reflection.
/// Collinear or too few (< 3) points are reported as not valid.
Alignment alignPoints(const std::vector<Eigen::Vector3d>& source, const std::vector<Eigen::Vector3d>& target,
                      const std::vector<double>& weights = {});

/// Same with rotation about z only (both frames gravity-aligned): x, y, z and yaw; needs 2 points apart in the plane.
Alignment alignPointsUpright(const std::vector<Eigen::Vector3d>& source, const std::vector<Eigen::Vector3d>& target,
                             const std::vector<double>& weights = {});

}  // namespace xview
