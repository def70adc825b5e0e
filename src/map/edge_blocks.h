// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "packed_bytes.h"
#include "xview/types/graph.h"

namespace xview {

/// The edges from 4096 successive vertices to later ones. Maps have ten times as many edges as
/// vertices, too many for a row each.
struct EdgeBlock {
  std::int64_t first_vertex = 0;
  std::uint32_t edges = 0;
  Bytes data;
};

/// Blocks with at least one edge, in order.
std::vector<EdgeBlock> toBlocks(const SemanticGraph& graph);

/// Fills the neighbour lists of a graph that has its vertices; throws Damage.
void setEdges(const std::vector<EdgeBlock>& blocks, SemanticGraph& graph);

}  // namespace xview
