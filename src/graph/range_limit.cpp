// SPDX-License-Identifier: BSD-3-Clause
#include "range_limit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace xview {
namespace {

constexpr float kNoDepth = 1e9F;       ///< and beyond
constexpr double kNear = 0.5;          ///< times the noise: this near to the limit ...
constexpr double kShare = 0.002;       ///< ... lie so many of the measurements, if there is one
constexpr std::size_t kFewest = 1000;  ///< measurements that can show a limit
constexpr double kKnown_m = 0.5;       ///< depths known to this are told as they are
constexpr double kLowest = 1.5;        ///< times the noise above the limit

/// Without branches, in four lanes, because all pixels are asked. 0 if nothing is measured.
float farthestOf(const std::vector<float>& depths) {
  std::array<float, 4> farthest{};
  for (std::size_t i = 0; i < depths.size(); ++i) {
    const float z = depths[i] < kNoDepth ? depths[i] : 0;
    float& lane = farthest[i % farthest.size()];
    lane = z > lane ? z : lane;
  }
  return *std::max_element(farthest.begin(), farthest.end());
}

/// phi / Phi of the normal distribution.
double shift(double mu) {
  const double density = std::exp(-0.5 * mu * mu) / std::sqrt(2 * M_PI);
  return density / (0.5 * std::erfc(-mu / std::sqrt(2.0)));
}

}  // namespace

std::optional<double> rangeLimit(const DepthImage& depth, double inverse_depth_sigma) {
  const float farthest = farthestOf(depth.pixels);
  if (!(inverse_depth_sigma * farthest * farthest > kKnown_m)) return std::nullopt;
  const double limit = 1 / (inverse_depth_sigma * farthest);
  const double near = 1 / (inverse_depth_sigma * (limit + kNear));
  std::size_t measured = 0, at_limit = 0;
  for (const float z : depth.pixels) {
    measured += static_cast<std::size_t>(z > 0) & static_cast<std::size_t>(z < kNoDepth);
    at_limit += static_cast<std::size_t>(z > near) & static_cast<std::size_t>(z < kNoDepth);
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
