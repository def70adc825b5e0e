// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/depth_noise.h"

#include <gtest/gtest.h>

#include <cmath>

#include "xview/types/random.h"

namespace xview {
namespace {

/// Two slanted planes with an edge between them; noise of the inverse depth in 1/m.
DepthImage twoPlanes(double noise, double measured_share = 1) {
  DepthImage depth(160, 120);
  Random random(1);
  for (int y = 0; y < depth.height; ++y) {
    for (int x = 0; x < depth.width; ++x) {
      const double inverse = (x < 70 ? 0.05 + 0.0005 * x : 0.2 - 0.0008 * x) + 0.0004 * y;
      const double measured = inverse + noise * random.normal();
      depth.at(x, y) = random.uniform() < measured_share ? static_cast<float>(1 / measured) : 0.f;
    }
  }
  return depth;
}

TEST(InverseDepthNoise, IsFoundOnSlantedPlanesAndPassesOverEdges) {
  for (const double noise : {0.0005, 0.0025})
    EXPECT_NEAR(inverseDepthNoise(twoPlanes(noise)), noise, 0.15 * noise);
}

TEST(InverseDepthNoise, IsNothingForPerfectDepth) {
  EXPECT_LT(inverseDepthNoise(twoPlanes(0)), 1e-6);
}

TEST(InverseDepthNoise, IsUnknownWithoutEnoughDepth) {
  EXPECT_EQ(inverseDepthNoise(DepthImage()), 0);
  EXPECT_EQ(inverseDepthNoise(twoPlanes(0.0025, 0.05)), 0);
  EXPECT_EQ(inverseDepthNoise(DepthImage(8, 120)), 0);
}

TEST(InverseDepthNoiseOfPixels, IsThatOfDepthWhosePixelsErr) {
  const DepthImage noisy = twoPlanes(0.002);
  EXPECT_TRUE(isNoiseOfPixels(inverseDepthNoise(noisy), noisy));
}

TEST(InverseDepthNoiseOfPixels, IsNoneForShapesLargerThanAPixel) {
  DepthImage wavy(160, 120);
  for (int y = 0; y < wavy.height; ++y) {
    for (int x = 0; x < wavy.width; ++x)
      wavy.at(x, y) = static_cast<float>(1 / (0.1 + 0.003 * std::sin(0.35 * x)));
  }
  EXPECT_GT(inverseDepthNoise(wavy), 0.001);
  EXPECT_FALSE(isNoiseOfPixels(inverseDepthNoise(wavy), wavy));
}

}  // namespace
}  // namespace xview
