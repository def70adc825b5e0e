// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "xview/types/localization.h"

namespace xview {

/// The 99.73 % quantile of the chi-square distribution with six degrees of freedom: an error beyond
/// it is further than three sigma (probability of a normal distribution) from the estimate.
constexpr double kThreeSigmaOfSix = 20.06;

/// Normalised estimation error squared, e^T covariance^-1 e (Bar-Shalom et al. 2001, 5.4.2): e is
/// the left increment in the map frame, position first, then rotation vector, as in
/// Localization::covariance. Mean 6 and median 5.35 if the covariance is right. Infinite if the
/// covariance is not positive definite.
double normalisedErrorSquared(const Matrix6d& covariance, const Eigen::Isometry3d& T_map_sensor,
                              const Eigen::Isometry3d& T_true);

/// How well a covariance tells the errors. NaN where there is no answer.
struct Consistency {
  std::size_t answers = 0;
  double mean = 0;  ///< of the normalised error squared over 6: 1 if right, less if it is too wide
  double median = 0;          ///< same; 0.89 if right
  double within_3_sigma = 0;  ///< share at most kThreeSigmaOfSix; 0.9973 if right
};

Consistency consistencyOf(const std::vector<double>& normalised_errors_squared);

}  // namespace xview
