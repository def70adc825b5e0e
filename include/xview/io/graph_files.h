// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "xview/types/graph.h"
#include "xview/types/labels.h"

namespace xview {

struct GraphFile {
  SemanticGraph graph;
  bool has_edges = false;  ///< false: the caller makes them by radius search
};

/// PLY with element vertex (x y z float or double, label, optional instance, observations, sigma,
/// extent_x/y/z) and optional element edge (vertex1 vertex2). Same strictness as readCloud; edges
/// out of range are errors.
GraphFile readGraph(const std::string& path);

/// ASCII PLY (doubles with 17 digits for positions), with red green blue per vertex; opens in any
/// mesh viewer. Written beside and renamed.
void writeGraph(const std::string& path, const SemanticGraph& graph, const LabelSet& labels);

}  // namespace xview
