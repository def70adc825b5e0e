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

}  // namespace xview
