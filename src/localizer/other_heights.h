// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "xview/localizer.h"
#include "xview/map/semantic_map.h"

namespace xview {

/// Another height of a pose in a map of one plane.
struct OtherHeight {
  double above = 0;  ///< of the pose, in lengths of the map
  double fit = 0;    ///< how well the query lies there, over how well it lies at the pose
};

/// The height, a storey away at least, at which the query fits the map best: decks of a garage and
/// floors of a building lie on one another in a bird's-eye view. What is level and what is not must
/// both lie on the map, so nothing but the like of a floor fits. Both upright, in canonical
/// lengths.
OtherHeight bestOtherHeight(const Query& query, const map::SemanticMap& map,
                            const Eigen::Isometry3d& T_map_query);

}  // namespace xview
