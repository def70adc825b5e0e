// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <vector>

namespace xview {

/// Positions of successive poses, cut where a step is more than 20 m and five times the usual one:
/// from one recording to the next.
std::vector<std::vector<Eigen::Vector3d>> trajectoryPieces(
    const std::vector<Eigen::Isometry3d>& poses);

}  // namespace xview
