// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "xview/localizer.h"

namespace xview {

/// The map in the frame that `upright` makes of its own; nothing if that is its own.
std::optional<SemanticMap> uprightMap(const SemanticMap& map, const Eigen::Quaterniond& upright);

/// The query in the frame that `upright` makes of its own.
Query uprightQuery(const Query& query, const Eigen::Quaterniond& upright);

/// A query as it is, or turned if it has to be.
struct UprightQuery {
  UprightQuery(const Query& given, const Eigen::Quaterniond& upright);
  UprightQuery(const UprightQuery&) = delete;
  const std::optional<Query> turned;
  const Query& query;  ///< `turned`, or the given one, which must live as long
};

/// Hypotheses, pose and covariance from gravity-aligned frames back to the frames of map and query.
void leaveUprightFrames(const Eigen::Quaterniond& map_upright,
                        const Eigen::Quaterniond& query_upright, const Query& query,
                        Localization& answer);

}  // namespace xview
