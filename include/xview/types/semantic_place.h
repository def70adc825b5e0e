// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "xview/types/frame.h"
#include "xview/types/graph.h"
#include "xview/types/gravity.h"
#include "xview/types/labelled_cloud.h"
#include "xview/types/labels.h"
#include "xview/types/localization.h"
#include "xview/types/plan_view.h"

namespace xview {

/// What is known of a piece of world, in one frame. A query is a place in the frame of its
/// odometry, a map is one with sources and a file; what was not seen, or is not told, is empty. All
/// parts of single precision carry their origin in double.
struct Place {
  LabelSet labels;
  SemanticGraph graph;  ///< the paper's graph: objects and pieces of surface
  PlanView plan;        ///< surfaces and objects seen from above; empty for bare graphs, and where
                        ///< nothing tells which way is up
  LabelledCloud cloud;  ///< for refinement and pictures; Point::view is a position in `poses`

  /// T_place_sensor of the frames that saw it, in order: all of a query, whose last one is answered
  /// (identity for a bare graph), or the key frames of a map.
  std::vector<Eigen::Isometry3d> poses;
  std::vector<std::int64_t> frames;  ///< their numbers; empty if there were no frames
  std::vector<double> stamps_s;      ///< and times [s]

  Sensor sensor = Sensor::cloud;  ///< that saw it last
  double size = 1;                ///< its lengths against those of a town; see place_size.h
  Gravity gravity;                ///< which way is up
  Timings timing_ms;              ///< what making it took: read, lift, blobs, graph
};

}  // namespace xview
