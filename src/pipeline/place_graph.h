// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "xview/graph/merge.h"
#include "xview/mapper.h"
#include "xview/options.h"

namespace xview {

/// Successive frames as one place graph, in the space that options.graph_space asks for.
class PlaceGraph {
 public:
  PlaceGraph(const LabelSet& labels, const Options& options);
  void add(const FrameDigest& frame);
  /// With edges. Thin objects stand where the plan view of the same frames has them, unless the
  /// graph is of image space or as in the paper.
  SemanticGraph finish(const PlanView& plan) const;

 private:
  PlaceGraphBuilder places_;
  LabelSet labels_;
  Options options_;
};

bool isImageSpace(const Options& options);

}  // namespace xview
