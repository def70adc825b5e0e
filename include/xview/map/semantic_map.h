// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

#include "xview/types/graph.h"
#include "xview/types/labelled_cloud.h"
#include "xview/types/labels.h"
#include "xview/types/plan_view.h"

namespace xview {

/// A pose from which a part of the map was seen.
struct Keyframe {
  std::int64_t number = 0;
  double stamp_s = 0;
  Eigen::Isometry3d T_map_sensor = Eigen::Isometry3d::Identity();
  std::uint32_t source = 0;  ///< index into SemanticMap::sources
};

/// A place that one can localize in. All parts are in the map frame; single-precision parts carry
/// their origin in double.
struct SemanticMap {
  LabelSet labels;
  SemanticGraph graph;  ///< the paper's graph G_db
  PlanView plan;  ///< fine surfaces and objects from above; empty for maps made of bare graphs
  LabelledCloud cloud;  ///< thinned, for refinement and pictures; may be empty
  std::vector<Keyframe> keyframes;
  std::vector<std::string> sources;  ///< inputs it was built from, in order
  std::string options_yaml;          ///< effective options of the last build
};

}  // namespace xview
