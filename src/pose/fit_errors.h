// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "registration.h"

namespace xview {

/// Covariance of the last pose of a fit: how the errors of its parts reach that pose through the
/// fit, see RefinementErrors. `sigma_m`: typical depth error of the points. `drift_shown`: the
/// window was found to drift as much as the options allow.
Matrix6d fitCovariance(const Registration& registration, const std::vector<QueryPoint>& points,
                       const Estimate& at, double sigma_m, bool drift_shown);

}  // namespace xview
