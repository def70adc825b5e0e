// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "narrative.h"
#include "xview/map/semantic_map.h"

namespace xview::tools {

/// True if most of the poses are where one of the others is.
bool areSamePoses(const std::vector<Eigen::Isometry3d>& poses,
                  const std::vector<Eigen::Isometry3d>& others, double tolerance_m);

/// Notes if what is added to a map is in it already, or does not fit where both have seen
/// something.
void sayDoubts(const map::SemanticMap& map, const map::SemanticMap& addition,
               const Narrative& narrate);

/// Notes if recordings that are to share one frame lie so far from one another that they hardly do.
/// `ways` are their poses.
void sayIfApart(const std::vector<std::string>& names,
                const std::vector<std::vector<Eigen::Isometry3d>>& ways, const Narrative& narrate);

}  // namespace xview::tools
