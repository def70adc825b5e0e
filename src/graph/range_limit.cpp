// SPDX-License-Identifier: BSD-3-Clause
#include "range_limit.h"

#include <algorithm>
#include <cmath>

namespace xview {
namespace {

constexpr double kNear = 0.5;          ///< times the noise: this near to the limit ...
constexpr double kShare = 0.002;       ///< ... lie so many of the measurements, if there is one
constexpr std::size_t kFewest = 1000;  ///< measurements that can show a limit
constexpr double kKnown_m = 0.5;       ///< depths known to this are told as they are
constexpr double kLowest = 1.5;        ///< times the noise above the limit

/// phi / Phi of the normal distribution.
double shift(double mu) {
  const double density = std::exp(-0.5 * mu * mu) / std::sqrt(2 * M_PI);
  return density / (0.5 * std::erfc(-mu / std::sqrt(2.0)));
}

}  // namespace

std::optional<double> rangeLimit(const DepthImage& depth, double inverse_depth_sigma) {
  const auto isMeasured = [](float z) { return z > 0 && z < 1e9F; };
  float farthest = 0;
  for (const float z : depth.pixels) farthest = isMeasured(z) ? std::max(farthest, z) : farthest;
  if (!(inverse_depth_sigma * farthest * farthest > kKnown_m)) return std::nullopt;
  const double limit = 1 / (inverse_depth_sigma * farthest);
  const double near = 1 / (inverse_depth_sigma * (limit + kNear));
  std::size_t measured = 0, at_limit = 0;
  for (const float z : depth.pixels) {
    if (!isMeasured(z)) continue;
    ++measured;
    at_limit += z > near;
  }
  if (measured < kFewest || static_cast<double>(at_limit) < kShare * static_cast<double>(measured))
    return std::nullopt;
  return limit;
}

std::optional<double> meanOfAll(double seen) {
  if (seen < kLowest + shift(kLowest)) return std::nullopt;
  double mu = seen;
  for (int i = 0; i < 20; ++i) mu = seen - shift(mu);
  return mu;
}

}  // namespace xview
