// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "xview/options.h"
#include "xview/types/graph.h"
#include "xview/types/labels.h"

namespace xview {

/// The graph that walks run on. Surfaces are spaced as in the paper (merge.first_observation_m,
/// first observation kept), because a walk over a fine lattice of road says nothing; objects stay
/// as they are. Edges by radius. A graph of image space is spaced already and keeps its edges, so
/// that either space can be matched against the other (paper, section III-B).
struct WalkGraph {
  SemanticGraph graph;
  std::vector<std::uint32_t> source;  ///< per vertex, its number in the full graph
};
WalkGraph walkGraph(const SemanticGraph& graph, const LabelSet& labels, const Options& options);

/// The vertices with these numbers (ascending). With the edges among them in image space; other
/// edges are made anew by walkGraph.
SemanticGraph inducedGraph(const SemanticGraph& graph, const std::vector<std::uint32_t>& numbers);

/// The positions of all vertices, in order.
std::vector<Eigen::Vector3d> positionsOf(const SemanticGraph& graph);

}  // namespace xview
