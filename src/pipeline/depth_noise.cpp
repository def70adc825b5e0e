// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/depth_noise.h"

#include <algorithm>
#include <cmath>
#include <vector>
#include "xview/types/median.h"

namespace xview {
namespace {

constexpr int kApart = 6;          ///< pixels over which errors are independent
constexpr double kOfPixels = 0.2;  ///< of the noise, what neighbouring pixels show of it at least
constexpr int kEvery = 3;          ///< rows and columns looked at
constexpr std::size_t kFewest = 200;
constexpr double kMedianOfAbs = 0.6745;       ///< of the standard normal distribution
constexpr double kNoiseOfSecond = 2.4494897;  ///< root of 1 + 4 + 1

/// From second differences over pixels this far apart.
double noiseOver(const DepthImage& depth, int step) {
  std::vector<float> seconds;
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

}  // namespace

double inverseDepthNoise(const DepthImage& depth) { return noiseOver(depth, kApart); }

bool isNoiseOfPixels(double inverse_depth_noise, const DepthImage& depth) {
  return inverse_depth_noise > 0 && noiseOver(depth, 1) >= kOfPixels * inverse_depth_noise;
}

}  // namespace xview
