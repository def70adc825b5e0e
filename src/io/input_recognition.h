// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace xview {

/// What the header of a .ply says it holds.
enum class PlyContent {
  cloud,  ///< points with more than positions and labels, or too many for a graph
  graph,  ///< edges, or properties that only graphs have
  bare    ///< positions, integer labels and perhaps instances: may be either
};
PlyContent plyContent(const std::string& path);  ///< throws Error

}  // namespace xview
