// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "xview/types/labels.h"

namespace xview {

/// A vertex in the making, as far as the vote about its class needs it.
struct Observed {
  std::uint32_t label = 0;
  Role role = Role::object;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d extent = Eigen::Vector3d::Zero();
  std::vector<std::int64_t> frames;  ///< ascending
};

/// For each one the number of the one that it is the same thing as: itself, or one that more frames
/// saw. The same thing is what a network calls a truck in some frames and a car in others: another
/// class of the same role within reach_m of one that at least three frames saw, its box over the
/// other's, and seldom (in at most a quarter of the frames of the rarer one) both in one frame.
/// What stands beside something else is seen together with it.
std::vector<std::size_t> sameThings(const std::vector<Observed>& all, double reach_m);

}  // namespace xview
