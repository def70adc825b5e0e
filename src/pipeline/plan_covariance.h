// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "xview/localizer.h"

namespace xview {

/// Of the last pose, where plan views were registered: x y z [m], rx ry rz [rad], map frame, left
/// increment. `up_sigma_rad`: how well up was measured in the query.
Matrix6d registeredPlanCovariance(const Query& query, const Eigen::Isometry3d& T_map_query,
                                  double up_sigma_rad);

}  // namespace xview
