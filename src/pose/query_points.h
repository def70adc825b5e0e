// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "distribution_cells.h"
#include "xview/pose/refine.h"

namespace xview {

/// A point of a query that takes part in a registration.
struct QueryPoint {
  Eigen::Vector3d p;  ///< query frame
  std::uint32_t group = kNoGroup;
  Eigen::Vector3d view = Eigen::Vector3d::Zero();  ///< unit vector to who saw it; zero if unknown
  std::size_t pose = 0;                            ///< that it was seen from
};

/// So many of all, evenly spread over their order.
template <class T>
std::vector<T> evenlySpread(const std::vector<T>& all, std::size_t count) {
  count = std::min(all.size(), count);
  std::vector<T> chosen;
  for (std::size_t k = 0; k < count; ++k) chosen.push_back(all[k * all.size() / count]);
  return chosen;
}

/// Points of static classes, about so many at most, in the order of the cloud: fewer of ground and
/// more of posts than the share that they have of it.
std::vector<QueryPoint> choosePoints(const RefineQuery& query, const LabelSet& labels,
                                     int max_points);

/// Where a point lies, and what it is of: points of one block err together.
using Block = std::array<std::int64_t, 3>;
Block blockOf(const QueryPoint& q);

/// Way from each pose to the last one.
std::vector<double> waysToLast(const std::vector<Eigen::Isometry3d>& poses);

}  // namespace xview
