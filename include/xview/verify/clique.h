// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "xview/verify/consistency.h"

namespace xview::verify {

/// Core number of each node (largest k such that the node survives in a subgraph of minimum degree
/// k).
std::vector<std::uint32_t> coreNumbers(const ConsistencyGraph& graph);

struct Clique {
  std::vector<std::uint32_t> nodes;  ///< sorted
  bool proven_maximum = false;       ///< false if the budget ran out
};

/// Maximum clique by branch and bound with greedy colouring (Tomita & Seki 2003; bit rows after
/// San Segundo 2011) after a greedy start and k-core pruning. The budget counts search nodes, not
/// time, so the result is repeatable; whatever it is, the result is a clique.
Clique maximumClique(const ConsistencyGraph& graph, int budget);

/// The nodes of the highest k-core, sorted: each agrees with at least k others of them. All nodes
/// if there are no edges.
std::vector<std::uint32_t> densestCore(const ConsistencyGraph& graph);

}  // namespace xview::verify
