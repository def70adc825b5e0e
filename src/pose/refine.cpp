// SPDX-License-Identifier: BSD-3-Clause
#include "xview/pose/refine.h"

#include <cmath>
#include <utility>

#include "fit_errors.h"
#include "query_points.h"
#include "registration.h"

namespace xview {
namespace {

constexpr double kSteady = 0.4;     ///< of the drift of the options, where a window shows none
constexpr double kTolerance = 30;   ///< where it may: points may be off by some 2 m
constexpr double kShownDrift = 50;  ///< by so much points must fit better with drift

/// A window under one presumption.
struct Fit {
  Registration registration;
  Registration::Descent descent;
  double cost = INFINITY;  ///< of the points, without what was presumed
};

void descend(const std::vector<QueryPoint>& points, const Estimate& start, int iterations,
             Fit& fit) {
  fit.descent = fit.registration.descend(points, start, iterations, true);
  if (fit.descent.valid) fit.cost = fit.registration.costOf(points, fit.descent.at);
}

Matrix6d covarianceOf(const Fit& fit, const Eigen::Matrix3d& start_open,
                      const std::vector<QueryPoint>& points, double sigma_m, bool drifts) {
  using E = RefinementErrors;
  Matrix6d covariance = fitCovariance(fit.registration, points, fit.descent.at, sigma_m, drifts);
  const double looks = std::sqrt(static_cast<double>(fit.registration.poseCount()));
  const double floor_m = std::hypot(E::kFloor_m, E::kLook_m / looks),
               floor_rad = std::hypot(E::kFloor_rad, E::kLook_rad / looks);
  covariance.diagonal().head<3>().array() += floor_m * floor_m;
  covariance.topLeftCorner<3, 3>() += E::kStarts * E::kStarts * start_open;
  covariance.diagonal().head<2>().array() += std::pow(E::kCommon * sigma_m, 2);
  covariance.diagonal().tail<3>().array() += floor_rad * floor_rad;
  return 0.5 * (covariance + covariance.transpose());
}

}  // namespace

Refinement refine(const DistributionMap& map, const RefineQuery& query, const LabelSet& labels,
                  const Eigen::Isometry3d& T_map_query, const RefineOptions& options) {
  Refinement result;
  result.T_map_query = T_map_query;
  const std::vector<QueryPoint> points = choosePoints(query, labels, options.max_points);
  if (points.size() < kFewestPartners) return result;
  const Eigen::Vector3d sensor = query.poses.back().translation();
  Fit steady{{map, query, T_map_query, points, options, {kSteady, 1}}, {}};
  Registration::Start start{steady.registration.start()};
  if (options.start_reach_m > 0) start = steady.registration.likelyStart(points);
  descend(points, start.at, 1 + 2 * options.iterations / 3, steady);
  Fit drifting{{map, query, T_map_query, points, options, {1, kTolerance}}, {}};
  Estimate undrifted = drifting.registration.start();
  undrifted.T_map_query = start.at.T_map_query;
  if (drifting.registration.canDrift()) descend(points, undrifted, options.iterations, drifting);
  const bool drifts = drifting.descent.valid &&
                      (!steady.descent.valid || steady.cost - drifting.cost > kShownDrift);
  const Fit& best = drifts ? drifting : steady;
  const Registration::Descent& d = best.descent;
  if (!d.valid) return result;
  result.T_map_query = d.at.T_map_query;
  result.iterations = d.iterations;
  result.overlap = static_cast<double>(d.last.partners) / static_cast<double>(points.size());
  result.scale = best.registration.scaleOf(d.at);
  // The noise of the map is there where that of the query is not known, too.
  const double sigma_m = std::hypot(query.cloud.typicalSigma(), DistributionCells::of(map).noise());
  result.covariance = covarianceOf(best, start.open, points, sigma_m, drifts);
  const double shift = (result.T_map_query * sensor - T_map_query * sensor).norm();
  result.converged = shift <= options.max_shift_m;
  return result;
}

}  // namespace xview
