// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <string>

#include "xview/place_builder.h"

namespace xview {

/// Throws UsageError unless the pose is a rigid motion within 1e8 m, or as far as cells of a place
/// of that size can be counted. `name`: what messages call it.
void requireNear(const std::string& name, const Eigen::Isometry3d& T, double size);
/// Throws UsageError unless vertices are finite and edges join those that there are.
void requireSound(const SemanticGraph& graph);
/// Throws UsageError unless the query has poses, all of which are near, and everything in it is a
/// number and names what there is.
void requireSound(const Query& query);
/// Where a cloud or graph was seen from: the given point, or the middle of what it shows if no
/// sensor can have stood so far away, as the origin of the coordinates of a country, where a
/// hundredth of a degree is a kilometre.
Eigen::Vector3d standpoint(const Eigen::Vector3d& given, const Eigen::AlignedBox3d& seen);

}  // namespace xview
