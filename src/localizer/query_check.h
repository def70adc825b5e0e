// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "xview/base/localization.h"
#include "xview/localizer.h"
#include "xview/map/semantic_map.h"
#include "xview/place_builder.h"

namespace xview {

/// Why a query cannot be found in the map wherever it is, and what to do about it; nothing if it is
/// worth a search. Both are at canonical scale; the query is in the classes of the map unless they
/// have nothing in common.
std::optional<std::string> whyUnfindable(const Query& query, const map::SemanticMap& map);

/// requireNear() for the pose; radius and angle must be numbers that are not negative.
void requireSound(const ExpectedPose& expected, double size);
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
/// False if nothing is known.
bool sayAnything(const Priors& priors);
/// True if the last pose of the sensor satisfies all priors.
bool satisfies(const Priors& priors, Sensor sensor, const Eigen::Isometry3d& T_map_sensor);

}  // namespace xview
