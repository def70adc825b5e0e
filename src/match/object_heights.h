// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

namespace xview {

/// Height of a map vertex above its query vertex, at a place of the query [m].
struct HeightPair {
  double x, y, rise;
  double weight = 1;   ///< of the pair in the cost
  double sigma = 0.5;  ///< of the rise of a true pair [m]
};

/// rise = offset + slope . (x, y): what lifts the query onto the map, and by how much it is tilted
/// [rad].
struct HeightFit {
  double offset = 0;
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();
};

/// Robust plane. Gravity is known to a degree or two, so slopes are held near zero; with few pairs
/// only the offset is found. The heights of a query without heights tell of the ground, not of a
/// tilt: `may_tilt` is false then.
HeightFit fitHeights(const std::vector<HeightPair>& pairs, bool may_tilt);

/// What a tilt and heights off the plane speak against a place [nats]: robust, 0 if all agree.
double heightCost(const std::vector<HeightPair>& pairs, const HeightFit& fit);

}  // namespace xview
