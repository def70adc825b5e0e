// SPDX-License-Identifier: BSD-3-Clause
#include "trajectory_pieces.h"

#include <algorithm>
#include "xview/types/median.h"

namespace xview {
namespace {

double longestStep(std::vector<double> steps) {
  constexpr double kAlwaysFine_m = 20, kTimesUsual = 5;
  if (steps.empty()) return kAlwaysFine_m;
  return std::max(kAlwaysFine_m, kTimesUsual * medianOf(std::move(steps)));
}

}  // namespace

std::vector<std::vector<Eigen::Vector3d>> trajectoryPieces(
    const std::vector<Eigen::Isometry3d>& poses) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < poses.size(); ++i)
    steps.push_back((poses[i].translation() - poses[i - 1].translation()).norm());
  const double longest = longestStep(steps);
  std::vector<std::vector<Eigen::Vector3d>> pieces;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (i == 0 || !(steps[i - 1] <= longest)) pieces.emplace_back();
    pieces.back().push_back(poses[i].translation());
  }
  return pieces;
}

}  // namespace xview
