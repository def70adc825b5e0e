// SPDX-License-Identifier: BSD-3-Clause
#include "object_heights.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include "xview/types/median.h"

namespace xview {
namespace {

constexpr double kSlopeSigma = 0.02;     // [rad]
constexpr std::size_t kFewestPairs = 6;  // to tell a slope
constexpr int kIterations = 5;
constexpr double kFreedom = 3;             // of the t distribution of the heights off the plane
constexpr double kIndependentShare = 0.7;  // of what heights say: neighbours are off together

double medianRise(const std::vector<HeightPair>& pairs) {
  std::vector<double> rises;
  for (const HeightPair& p : pairs) rises.push_back(p.rise);
  return medianOf(std::move(rises));
}

}  // namespace

HeightFit fitHeights(const std::vector<HeightPair>& pairs, bool may_tilt) {
  HeightFit fit;
  if (pairs.empty()) return fit;
  fit.offset = medianRise(pairs);
  if (!may_tilt || pairs.size() < kFewestPairs) return fit;
  for (int k = 0; k < kIterations; ++k) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    normal(1, 1) = normal(2, 2) = 1 / (kSlopeSigma * kSlopeSigma);
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const HeightPair& p : pairs) {
      const double residual =
          (p.rise - fit.offset - fit.slope.dot(Eigen::Vector2d(p.x, p.y))) / p.sigma;
      const double weight = 1 / (p.sigma * p.sigma * (1 + residual * residual));  // Cauchy
      const Eigen::Vector3d row(1, p.x, p.y);
      normal += weight * row * row.transpose();
      right += weight * p.rise * row;
    }
    const Eigen::Vector3d solution = normal.ldlt().solve(right);
    fit.offset = solution[0];
    fit.slope = solution.tail<2>();
  }
  return fit;
}

double heightCost(const std::vector<HeightPair>& pairs, const HeightFit& fit) {
  double cost = 2 * std::log1p(0.5 * fit.slope.squaredNorm() / (kSlopeSigma * kSlopeSigma));
  for (const HeightPair& p : pairs) {
    const double off = (p.rise - fit.offset - fit.slope.dot(Eigen::Vector2d(p.x, p.y))) / p.sigma;
    cost += kIndependentShare * p.weight * std::log1p(off * off / kFreedom);
  }
  return cost;
}

}  // namespace xview
