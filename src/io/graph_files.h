// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "xview/base/graph.h"
#include "xview/base/labels.h"

namespace xview::io {

struct GraphFile {
  SemanticGraph graph;
  bool has_edges = false;          ///< false: the caller makes them by radius search
  std::optional<LabelSet> labels;  ///< the classes that its comments name
};

/// PLY with element vertex (x y z float or double, label, optional instance, observations, points,
/// sigma, extent_x/y/z, first_frame, last_frame) and optional element edge (vertex1 vertex2). As
/// strict as readCloud; positions that are not finite and edges to vertices that do not exist are
/// errors. The comment `graph_space image` marks edges found in images. Throws Error.
GraphFile readGraph(const std::string& path);

/// ASCII PLY with red green blue per vertex, which opens in any mesh viewer, and the classes as
/// comments; numbers have as many
/// digits as it takes to read back the same graph. Written beside and renamed. Throws Error.
void writeGraph(const std::string& path, const SemanticGraph& graph, const LabelSet& labels);

}  // namespace xview::io
