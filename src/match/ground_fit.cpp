// SPDX-License-Identifier: BSD-3-Clause
#include "match/ground_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include "xview/types/median.h"

namespace xview {
namespace {

constexpr int kRounds = 12;
constexpr double kFirstGate_m = 4, kLastGate_m = 0.15;  ///< of residuals that count in full
constexpr std::size_t kFewestCells = 30;
constexpr double kAlike = 30;  ///< so many cells err together: roads are smooth, and so is drift

/// Height of the map above a cell of the query, which lies at (x, y) from the centre in map axes.
struct Difference {
  double x = 0, y = 0, dz = 0;
};

std::vector<Difference> differences(const PlanField& field,
                                    const std::vector<PlanQuery::Ground>& ground,
                                    const PlacePose& pose) {
  const double c = std::cos(pose.yaw), s = std::sin(pose.yaw);
  std::vector<Difference> found;
  for (const PlanQuery::Ground& q : ground) {
    const double x = c * q.x - s * q.y, y = s * q.x + c * q.y;
    const auto cx = static_cast<std::int32_t>(std::floor((pose.x + x) / field.cellSize())),
               cy = static_cast<std::int32_t>(std::floor((pose.y + y) / field.cellSize()));
    const PlanField::Tile* tile = field.tileOfCell(cx, cy);
    if (!tile) continue;
    const float height = tile->ground[PlanField::cellInTile(cx, cy)];
    if (!std::isnan(height)) found.push_back({x, y, height - double{q.z}});
  }
  return found;
}

double medianHeight(const std::vector<Difference>& all) {
  std::vector<double> heights;
  for (const Difference& d : all) heights.push_back(d.dz);
  return medianOf(std::move(heights));
}

}  // namespace

/// Least squares with weights of Geman-McClure, whose gate narrows (graduated non-convexity).
GroundFit fitGround(const PlanField& field, const std::vector<PlanQuery::Ground>& ground,
                    const PlacePose& centre_pose, double slope_sigma) {
  GroundFit fit;
  const std::vector<Difference> cells = differences(field, ground, centre_pose);
  if (cells.size() < kFewestCells) return fit;
  Eigen::Vector3d plane(medianHeight(cells), 0, 0);
  for (int round = 0; round < kRounds; ++round) {
    const double gate = std::max(
        kLastGate_m, kFirstGate_m * std::pow(kLastGate_m / kFirstGate_m, round / (0.6 * kRounds)));
    Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    double weights = 0, squares = 0;
    for (const Difference& d : cells) {
      const Eigen::Vector3d J(1, d.x, d.y);
      const double r = d.dz - plane.dot(J);
      const double weight = 1 / std::pow(1 + r * r / (gate * gate), 2);
      H += weight * J * J.transpose();
      b += weight * r * J;
      weights += weight;
      squares += weight * r * r;
    }
    const double variance = kAlike * std::max(squares / weights, 1e-4);
    H /= variance;
    b /= variance;
    const double level = 1 / (slope_sigma * slope_sigma);
    H.diagonal().tail<2>().array() += level;
    b.tail<2>() -= level * plane.tail<2>();
    plane += H.ldlt().solve(b);
    fit.covariance = H.inverse();
    fit.cells = static_cast<int>(weights);
  }
  fit.height_m = plane(0);
  fit.slope = plane.tail<2>();
  return fit;
}

}  // namespace xview
