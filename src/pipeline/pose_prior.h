// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "xview/localizer.h"
#include "xview/types/place.h"

namespace xview {

/// Reads PriorOptions; throws UsageError with the key.
PlacePrior parsePrior(const PriorOptions& options);

/// What a prior of the last sensor pose says about the pose of another point of the query (and about the yaw of its frame).
PlacePrior priorOfPoint(const PlacePrior& prior, const Query& query, const Eigen::Vector2d& point);

/// True if the last sensor pose satisfies the prior.
bool satisfies(const PlacePrior& prior, const Query& query, const Eigen::Isometry3d& T_map_query);

}  // namespace xview
