// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "xview/match/plan_field.h"

namespace xview {

/// Per channel, how the distance classes are distributed at wrong poses in this very map.
using MapNull = std::array<std::array<double, kDistanceBins>, kChannels>;

/// Puts what lies within 30 m of one sensor position at another one at least 25 m away, heading
/// aligned or reversed, and counts. In a town of equal streets a generic street fits everywhere;
/// likelihoods learned elsewhere do not know that. `path`: sensor positions in plan coordinates.
/// All zero if the path is too short to say anything.
MapNull mapNull(const PlanView& map, const std::vector<Eigen::Vector2d>& path,
                const PlanField& field);

}  // namespace xview
