// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

namespace xview {

/// The q-quantile (0 = smallest, 0.5 = median, 1 = largest), linear between neighbours; NaN if
/// there are no values.
double quantile(std::vector<double> values, double q);

/// Share of `total` that has a value within the limit (inclusive); values that are not finite never
/// have. NaN if total is 0.
double shareWithin(const std::vector<double>& values, double limit, std::size_t total);

}  // namespace xview
