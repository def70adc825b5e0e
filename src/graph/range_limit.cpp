// SPDX-License-Identifier: BSD-3-Clause
#include "range_limit.h"

#include <cmath>
#include <limits>

#include "row_loops.h"

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

float roundedDown(double value) {
  const auto rounded = static_cast<float>(value);
  return rounded > value ? std::nextafter(rounded, 0.F) : rounded;
}

}  // namespace

std::optional<double> rangeLimit(const DepthImage& depth, double inverse_depth_sigma) {
  const float* depths = depth.pixels.data();
  const float farthest = farthestDepth(depths, depth.pixels.size());
  if (!(inverse_depth_sigma * farthest * farthest > kKnown_m)) return std::nullopt;
  const double limit = 1 / (inverse_depth_sigma * farthest);
  const float near = roundedDown(1 / (inverse_depth_sigma * (limit + kNear)));
  const DepthCounts counts =
      countDepths(depths, depth.pixels.size(), near, std::numeric_limits<float>::max());
  if (counts.measured < kFewest ||
      static_cast<double>(counts.within) < kShare * static_cast<double>(counts.measured))
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
