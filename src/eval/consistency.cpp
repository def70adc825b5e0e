// SPDX-License-Identifier: BSD-3-Clause
#include "xview/eval/consistency.h"

#include <Eigen/Cholesky>
#include <limits>
#include <numeric>

#include "xview/eval/statistics.h"

namespace xview {
namespace {

constexpr double kFreedom = 6;

}  // namespace

double normalisedErrorSquared(const Matrix6d& covariance, const Eigen::Isometry3d& T_map_sensor,
                              const Eigen::Isometry3d& T_true) {
  const Eigen::AngleAxisd turn(
      Eigen::Matrix3d(T_true.linear() * T_map_sensor.linear().transpose()));
  Eigen::Matrix<double, 6, 1> error;
  error << T_true.translation() - T_map_sensor.translation(), turn.angle() * turn.axis();
  const Eigen::LLT<Matrix6d> root(covariance);
  if (root.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
  return root.matrixL().solve(error).squaredNorm();
}

Consistency consistencyOf(const std::vector<double>& normalised_errors_squared) {
  const std::vector<double>& values = normalised_errors_squared;
  Consistency result;
  result.answers = values.size();
  result.mean = std::accumulate(values.begin(), values.end(), 0.0) /
                (kFreedom * static_cast<double>(values.size()));
  result.median = quantile(values, 0.5) / kFreedom;
  result.within_3_sigma = shareWithin(values, kThreeSigmaOfSix, values.size());
  return result;
}

}  // namespace xview
