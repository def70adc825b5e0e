// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "graph/point_rows.h"
#include "xview/graph/smooth_depth.h"
#include "xview/types/median.h"

namespace xview::graph {
namespace {

constexpr int kApart = 6;          ///< pixels over which errors are independent
constexpr double kOfPixels = 0.2;  ///< of the noise, what neighbouring pixels show of it at least
constexpr int kEvery = 3;          ///< rows and columns looked at
constexpr std::size_t kFewest = 200;          ///< second differences that tell the noise
constexpr double kMedianOfAbs = 0.6745;       ///< of the standard normal distribution
constexpr double kNoiseOfSecond = 2.4494897;  ///< root of 1 + 4 + 1

/// From second differences over pixels this far apart.
double noiseOver(const DepthImage& depth, int step) {
  std::vector<float> seconds;
  seconds.reserve(depth.pixels.size() / (kEvery * kEvery) + depth.height);
  for (int y = 0; y < depth.height; y += kEvery) {
    for (int x = step; x + step < depth.width; x += kEvery) {
      const float left = depth.at(x - step, y), middle = depth.at(x, y),
                  right = depth.at(x + step, y);
      if (!(left > 0 && middle > 0 && right > 0)) continue;
      seconds.push_back(std::abs(1 / left - 2 / middle + 1 / right));
    }
  }
  if (seconds.size() < kFewest) return 0;
  return medianOf(std::move(seconds)) / (kMedianOfAbs * kNoiseOfSecond);
}

constexpr double kNear = 0.5;     ///< times the noise: this near to the limit ...
constexpr double kShare = 0.002;  ///< ... lie so many of the measurements, if there is one
constexpr std::size_t kFewestMeasured = 1000;  ///< measurements that can show a limit
constexpr double kKnown_m = 0.5;               ///< depths known to this are told as they are
constexpr double kLowest = 1.5;                ///< times the noise above the limit

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

double inverseDepthNoise(const DepthImage& depth) { return noiseOver(depth, kApart); }

bool isNoiseOfPixels(double inverse_depth_noise, const DepthImage& depth) {
  return inverse_depth_noise > 0 && noiseOver(depth, 1) >= kOfPixels * inverse_depth_noise;
}

std::optional<double> rangeLimit(const DepthImage& depth, double inverse_depth_sigma) {
  const float* depths = depth.pixels.data();
  const float farthest = farthestDepth(depths, depth.pixels.size());
  if (!(inverse_depth_sigma * farthest * farthest > kKnown_m)) return std::nullopt;
  const double limit = 1 / (inverse_depth_sigma * farthest);
  const float near = roundedDown(1 / (inverse_depth_sigma * (limit + kNear)));
  const DepthCounts counts =
      countDepths(depths, depth.pixels.size(), near, std::numeric_limits<float>::max());
  if (counts.measured < kFewestMeasured ||
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

}  // namespace xview::graph
