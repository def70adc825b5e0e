// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "object_map.h"

namespace xview {

/// A circle of a query that is too large to be searched for as a whole.
struct QueryPart {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< in the frame of the query [m]
  double radius = 0;                                 ///< [m]
};

/// The circle around all vertices of a query that the map could know.
QueryPart wholeOf(const SemanticGraph& query, const ObjectMap& map);

/// Where a query holds most objects: `count` parts at most, densest first, apart from one another.
/// Each is large enough to be told from other places, if the query is.
std::vector<QueryPart> denseParts(const SemanticGraph& query, const ObjectMap& map,
                                  std::size_t count);

}  // namespace xview
