// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace xview {

/// A believed identity of a query vertex and a map vertex.
struct Correspondence {
  std::uint32_t query = 0;  ///< index of the vertex in the query graph
  std::uint32_t map = 0;    ///< index of the vertex in the map graph
  float similarity = 0;     ///< of their descriptors, in [0, 1]
};

}  // namespace xview
