// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "pipeline/walk_graph.h"
#include "xview/types/localization.h"

namespace xview {

/// Vertices of one class that a pose brings within `reach_m` of each other, nearest first, each
/// used once; numbers of the full graphs.
std::vector<Correspondence> pairsUnderPose(const WalkGraph& query, const WalkGraph& map,
                                           const Eigen::Isometry3d& T_map_query, double reach_m);

/// Covariance of the sensor pose if each pair fixes its vertex with `sigma_m`: x y z rx ry rz, map
/// frame. Without enough pairs it is that of somebody who knows the place and no more: 5 m, 30
/// degrees.
Matrix6d covarianceOfPairs(const std::vector<Correspondence>& pairs, const SemanticGraph& map,
                           const Eigen::Vector3d& sensor_in_map, double sigma_m);

}  // namespace xview
