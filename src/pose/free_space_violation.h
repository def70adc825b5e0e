// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "pose/distribution_map.h"
#include "pose/refine.h"
#include "xview/base/labels.h"

namespace xview::pose {

/// Free-space violation: of the distributions of the map that rays of the query reach, the share
/// that rays pass through and where the query has no points, over the same share some metres off.
/// Near 0 at a true pose, near 1 at a wrong one; the noise of the map and changes count in both.
/// Independent of classes.
///
/// None if points have no view, so that no ray is known, if too little of the map lies there, or if
/// the share some metres off is near 0 as well.
std::optional<double> freeSpaceViolation(const DistributionMap& map, const RefineQuery& query,
                                         const LabelSet& labels,
                                         const Eigen::Isometry3d& T_map_query);

}  // namespace xview::pose
