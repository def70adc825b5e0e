// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "xview/types/graph.h"

namespace xview {

/// The edges that a picture shows: all of them, or, of a graph with more than six edges per vertex,
/// those that are among the three shortest of one of their ends. Edges of vertices that are not
/// finite are left out.
std::vector<std::pair<std::uint32_t, std::uint32_t>> readableEdges(const SemanticGraph& graph);

}  // namespace xview
