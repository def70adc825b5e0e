// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include "xview/localizer.h"

namespace xview {

/// The query with every length times `scale`, about the origin of its frame: odometry and depths of
/// one camera are off by one factor.
Query scaledQuery(const Query& query, double scale);

/// What the search for a scale needs of a localizer, for queries in the frame of the caller.
struct ScaleProbe {
  /// The best place of a query and its score, without any verdict; score 0 if there is none.
  std::function<PoseCheck(const Query&)> search;
  /// The best pose around a given one.
  std::function<PoseCheck(const Query&, const Eigen::Isometry3d& T_map_query)> climb;
};

struct FoundScale {
  double scale = 1;
  double rival_score = 0;  ///< of the best place elsewhere with any other scale
};

/// Searches with scales 6 % apart, climbs from the best of them in pose and scale by turns.
FoundScale findScale(const Query& query, const ScaleRange& range, const ScaleProbe& probe);

}  // namespace xview
