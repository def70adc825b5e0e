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
  /// With edges.
  SemanticGraph finish() const;

 private:
  PlaceGraphBuilder places_;
  Options options_;
};

bool isImageSpace(const Options& options);

}  // namespace xview
