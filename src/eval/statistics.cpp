// SPDX-License-Identifier: BSD-3-Clause
#include "xview/eval/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace xview {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

}  // namespace

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return kUnknown;
  std::sort(values.begin(), values.end());
  const double rank = std::clamp(q, 0.0, 1.0) * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(rank);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  const double part = rank - static_cast<double>(below);
  return part == 0 ? values[below] : values[below] + part * (values[above] - values[below]);
}

double shareWithin(const std::vector<double>& values, double limit, std::size_t total) {
  if (total == 0) return kUnknown;
  const auto within =
      std::count_if(values.begin(), values.end(), [&](double v) { return v <= limit; });
  return static_cast<double>(within) / static_cast<double>(total);
}

}  // namespace xview
