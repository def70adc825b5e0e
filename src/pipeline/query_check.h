// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "xview/localizer.h"
#include "xview/map/semantic_map.h"
#include "xview/place_builder.h"
#include "xview/query_check.h"
#include "xview/types/localization.h"

namespace xview {

/// Throws UsageError if the prior, in the frame and lengths of the map, excludes all of it.
void requirePriorInside(const PlacePrior& prior, const map::SemanticMap& map);

/// Everything known about the last sensor pose of a query; all of it must hold. Gravity-aligned
/// frames.
using Priors = std::vector<PlacePrior>;

/// Reads PriorOptions; throws UsageError with the key.
PlacePrior parsePrior(const PriorOptions& options);
/// The surroundings of an expected pose.
PlacePrior priorAround(const ExpectedPose& expected, const Query& query);

/// The same priors with the heading of the query frame in the place of that of its last sensor.
Priors ofQueryFrame(Priors priors, const Query& query);
/// True if the last sensor pose satisfies all priors.
bool satisfies(const Priors& priors, const Query& query, const Eigen::Isometry3d& T_map_query);

}  // namespace xview
