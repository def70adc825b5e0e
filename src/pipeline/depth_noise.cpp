// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/depth_noise.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace xview {
namespace {

constexpr int kStep = 6;         ///< pixels between the three depths: errors of neighbours are not independent
constexpr int kEvery = 3;        ///< rows and columns looked at
constexpr std::size_t kFewest = 200;
constexpr double kMedianOfAbs = 0.6745;       ///< of the standard normal distribution
constexpr double kNoiseOfSecond = 2.4494897;  ///< root of 1 + 4 + 1

}  // namespace

double inverseDepthNoise(const DepthImage& depth) {
  std::vector<float> seconds;
  for (int y = 0; y < depth.height; y += kEvery) {
    for (int x = kStep; x + kStep < depth.width; x += kEvery) {
      const float left = depth.at(x - kStep, y), middle = depth.at(x, y), right = depth.at(x + kStep, y);
      if (!(left > 0 && middle > 0 && right > 0)) continue;
      seconds.push_back(std::abs(1 / left - 2 / middle + 1 / right));
    }
  }
  if (seconds.size() < kFewest) return 0;
  const auto half = seconds.begin() + static_cast<std::ptrdiff_t>(seconds.size() / 2);
  std::nth_element(seconds.begin(), half, seconds.end());
  return *half / (kMedianOfAbs * kNoiseOfSecond);
}

}  // namespace xview
