// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/plan_covariance.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "xview/types/median.h"

namespace xview {
namespace {

/// Of the plan registered around the last pose, from kPlanSeenFrom_m above the ground; from higher
/// it errs with the square, as depth does. It was seen some 25 m before, from where the odometry
/// has drifted since; across the way and in height little is open. Tilt is that of the odometry.
constexpr double kPlanSeenFrom_m = 45;
constexpr double kPlanAlong_m = 0.25, kPlanAcross_m = 0.11, kPlanUp_m = 0.12,
                 kPlanTilt_rad = 0.0025, kPlanTurn_rad = 0.0065;

/// Level direction of the last metres of travel, map frame; zero if it stood.
Eigen::Vector3d recentTravel(const Query& query, const Eigen::Isometry3d& T_map_query) {
  constexpr double kEnough_m = 2;
  const Eigen::Vector3d last = query.poses.back().translation();
  for (std::size_t i = query.poses.size(); i-- > 0;) {
    Eigen::Vector3d way = T_map_query.linear() * (last - query.poses[i].translation());
    way.z() = 0;
    if (way.norm() > kEnough_m) return way.normalized();
  }
  return Eigen::Vector3d::Zero();
}

/// Of the last sensor, over the ground that the query has measured.
double heightOverGround(const Query& query) {
  std::vector<float> heights;
  for (const GroundCell& cell : query.plan.known) {
    if (cell.measured) heights.push_back(cell.z);
  }
  if (heights.empty()) return 0;
  const Eigen::Vector3d sensor = query.plan.upright * query.poses.back().translation();
  return sensor.z() - query.plan.origin_z - medianOf(std::move(heights));
}

}  // namespace

Matrix6d registeredPlanCovariance(const Query& query, const Eigen::Isometry3d& T_map_query,
                                  double up_sigma_rad) {
  const double higher = std::max(1.0, std::pow(heightOverGround(query) / kPlanSeenFrom_m, 2));
  const double along_m = higher * kPlanAlong_m, across_m = higher * kPlanAcross_m;
  const double tilt_rad = std::hypot(kPlanTilt_rad, up_sigma_rad);
  Eigen::Matrix<double, 6, 1> sigma;
  sigma << across_m, across_m, higher * kPlanUp_m, tilt_rad, tilt_rad, kPlanTurn_rad;
  Matrix6d covariance = sigma.cwiseAbs2().asDiagonal();
  const Eigen::Vector3d travel = recentTravel(query, T_map_query);
  covariance.topLeftCorner<3, 3>() +=
      (along_m * along_m - across_m * across_m) * travel * travel.transpose();
  return covariance;
}

}  // namespace xview
