// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "xview/pose/distribution_map.h"
#include "xview/pose/refine.h"
#include "xview/types/labels.h"

namespace xview::pose {

/// How much of what stands in the map a query saw through: the share of the distributions of the
/// map that lie where rays of the query passed and nothing of it stands, of all those that it could
/// tell, over the same share some metres off. Near 0 at a true pose, near 1 anywhere else, where
/// the noise of the map and what has changed count in both. Classes do not count, only that
/// something stands there, so it tells what no label can.
///
/// None if points are of no view, so that no ray is known, if too little of the map lies there, or
/// if hardly anything would be seen through at a wrong place either.
std::optional<double> freeSpaceViolation(const DistributionMap& map, const RefineQuery& query,
                                         const LabelSet& labels,
                                         const Eigen::Isometry3d& T_map_query);

}  // namespace xview::pose
