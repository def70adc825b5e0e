// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "xview/base/graph.h"
#include "xview/options.h"

namespace xview {

/// Replaces the edges of a graph: an edge joins vertices whose Euclidean distance is <= radius_m
/// (paper section III-B, 3-D space), found by pcl::KdTreeFLANN and decided in double precision.
/// With `nearest` > 0 one of the two must also be among the `nearest` nearest of the other, as
/// FLANN finds them in single precision. Vertices whose position is not finite stay alone.
void connectByRadius(SemanticGraph& graph, const EdgeOptions& options, int nearest = 0);

/// The same edges, left to makeEdges(): most of what is done with a graph needs none.
void useRadius(SemanticGraph& graph, const EdgeOptions& options);

/// Fills the neighbour lists of a graph that has an edge radius instead of them.
void makeEdges(SemanticGraph& graph);

struct EdgeCount {
  std::size_t edges = 0;
  std::size_t parts = 0;  ///< connected ones; a vertex without edges is one
};

/// Of the edges that makeEdges() would make, without making them: a map of 100 km has 70 million.
EdgeCount countEdges(const SemanticGraph& graph);

}  // namespace xview
