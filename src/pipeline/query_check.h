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

/// Throws UsageError unless the pose is a rigid motion within 1e8 m, or as far as cells of a place
/// of that size can be counted. `name`: what messages call it.
void requireNear(const std::string& name, const Eigen::Isometry3d& T, double size);
/// The same for the pose; radius and angle must be numbers that are not negative.
void requireSound(const ExpectedPose& expected, double size);
/// Throws UsageError unless vertices are finite and edges join those that there are.
void requireSound(const SemanticGraph& graph);
/// Throws UsageError unless the query has poses, all of which are near, and everything in it is a
/// number and names what there is.
void requireSound(const Query& query);
/// Throws UsageError if the answer pairs vertices that query or map do not have.
void requireAnswerTo(const Query& query, const map::SemanticMap& map, const Localization& answer);

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
