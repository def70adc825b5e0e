// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "xview/localizer.h"

namespace xview {

/// True if a frame had to be turned for z to point up (see uprightRotation).
bool isTurned(const Eigen::Quaterniond& upright);

/// The map in its gravity-aligned frame, if its own is not.
std::optional<SemanticMap> uprightMap(const SemanticMap& map);

/// The query in its gravity-aligned frame.
Query uprightQuery(const Query& query);

/// A query as it is, or turned if it has to be.
struct UprightQuery {
  explicit UprightQuery(const Query& given) : turned(isTurned(given.plan.upright) ? std::optional(uprightQuery(given)) : std::nullopt),
                                              query(turned ? *turned : given) {}
  UprightQuery(const UprightQuery&) = delete;
  const std::optional<Query> turned;
  const Query& query;  ///< `turned`, or the given one, which must live as long
};

/// Hypotheses, pose and covariance from gravity-aligned frames back to the frames of map and query.
void leaveUprightFrames(const Eigen::Quaterniond& map_upright, const Query& query, Localization& answer);

}  // namespace xview
