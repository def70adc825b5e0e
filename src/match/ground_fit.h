// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "xview/match/plan_field.h"
#include "xview/match/plan_places.h"

namespace xview {

/// How the measured ground of the map lies against that of a query at a pose of its centre (plan
/// coordinates). `slope_sigma`: how far off level the query may be [m/m].
GroundFit fitGround(const PlanField& field, const std::vector<PlanQuery::Ground>& ground,
                    const PlacePose& centre_pose, double slope_sigma);

/// Median height of the map, relative to the origin of its plan, above a query at a pose of its
/// centre. Where no measured ground of both meets, the ground below their samples is compared,
/// known only from what stands on it; 0 if they do not meet at all.
double heightOffset(const PlanField& field, const PlanQuery& query, const PlacePose& centre_pose);

}  // namespace xview
