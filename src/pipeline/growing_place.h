// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/place_graph.h"
#include "xview/graph/plan_view.h"
#include "xview/types/gravity.h"

namespace xview {

/// Plan view and place graph of frames that come one by one and are not kept. The first frames of a
/// recording tell together which way is up; only these wait.
class GrowingPlace {
 public:
  GrowingPlace(const LabelSet& labels, const Options& options);
  void add(FrameDigest frame);
  /// A recording is over: frames that wait are all that tell which way is up.
  void endRecording();

  struct Place {
    PlanView plan;
    SemanticGraph graph;  ///< with edges
    Gravity gravity;
  };
  Place finish() const;  ///< after the end of a recording

 private:
  void settleUpright();
  void addUpright(const FrameDigest& frame);

  LabelSet labels_;
  std::string gravity_;
  PlaceGraph graph_;
  PlanViewBuilder plan_;
  std::vector<FrameDigest> waiting_;  ///< until upright_ is known
  std::optional<Gravity> upright_;
};

}  // namespace xview
