// SPDX-License-Identifier: BSD-3-Clause
#include "xview/graph/smooth_depth.h"

#include <gtest/gtest.h>

#include <cmath>

#include "xview/types/random.h"

namespace xview::test {

using namespace graph;

namespace {

constexpr double kSigma = 0.00125;  ///< of inverse depth [1/m]: 2.5 m at 45 m
constexpr int kWidth = 160, kHeight = 120;

/// A surface seen straight on by a sensor that tells nothing beyond `max_m`.
DepthImage surfaceAt(double z, double max_m, std::uint64_t seed = 3) {
  DepthImage depth(kWidth, kHeight);
  Random random(seed);
  for (float& pixel : depth.pixels) {
    const double measured = 1 / (1 / z + kSigma * random.normal());
    pixel = measured > 0 && measured <= max_m ? static_cast<float>(measured) : 0;
  }
  return depth;
}

/// Inverse of the mean inverse depth, which noise does not move.
double meanOf(const DepthImage& depth) {
  double sum = 0;
  int n = 0;
  for (const float z : depth.pixels) {
    if (z > 0) sum += 1 / z, ++n;
  }
  return n / sum;
}

DepthImage smoothed(DepthImage depth) {
  smoothDepth(depth, LabelImage(kWidth, kHeight, 3), kSigma, 0.05);
  return depth;
}

TEST(RangeLimit, IsWhereTheMeasurementsOfASurfaceEnd) {
  const auto limit = rangeLimit(surfaceAt(45, 50), kSigma);
  ASSERT_TRUE(limit);
  EXPECT_NEAR(*limit * kSigma, 1 / 50.0, 1e-4);
}

TEST(RangeLimit, IsNotTheFarthestMeasurementOfASurfaceThatIsSeenWhole) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed)
    EXPECT_FALSE(rangeLimit(surfaceAt(45, 1000, seed), kSigma)) << seed;
}

TEST(RangeLimit, IsNotTheStepOfASensorThatKnowsDepthsWell) {
  DepthImage depth(kWidth, kHeight, 5.F);
  EXPECT_FALSE(rangeLimit(depth, 0.001)) << "good to 2.5 cm at 5 m";
  EXPECT_FALSE(rangeLimit(DepthImage(kWidth, kHeight, 0.F), kSigma));
  EXPECT_FALSE(rangeLimit(DepthImage(kWidth, kHeight, 45.F), 0));
}

TEST(RangeLimit, MeanOfAllIsFoundFromThatOfThoseThatAreTold) {
  Random random(5);
  for (const double mu : {1.7, 2.0, 3.0, 6.0}) {
    double sum = 0;
    int n = 0;
    for (int i = 0; i < 200000; ++i) {
      const double w = mu + random.normal();
      if (w > 0) sum += w, ++n;
    }
    const auto found = meanOfAll(sum / n);
    ASSERT_TRUE(found) << mu;
    EXPECT_NEAR(*found, mu, 0.02);
  }
  EXPECT_FALSE(meanOfAll(1.2)) << "the tail of something beyond the limit";
  EXPECT_FALSE(meanOfAll(-1));
}

TEST(RangeLimit, ASurfaceNearItIsWhereItIsAfterSmoothing) {
  const DepthImage told = surfaceAt(45, 50);
  EXPECT_LT(meanOf(told), 44.85) << "what is told is too near";
  EXPECT_NEAR(meanOf(smoothed(told)), 45, 0.08);
  EXPECT_NEAR(meanOf(smoothed(surfaceAt(45, 1000))), 45, 0.08);
}

TEST(RangeLimit, ASurfaceBeyondItLosesItsDepth) {
  const DepthImage told = surfaceAt(45, 42);
  std::size_t before = 0, after = 0;
  const DepthImage left = smoothed(told);
  for (std::size_t i = 0; i < told.pixels.size(); ++i) {
    before += told.pixels[i] > 0;
    after += left.pixels[i] > 0;
  }
  EXPECT_GT(before, told.pixels.size() / 20);
  EXPECT_LT(after, before / 20);
}

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
}  // namespace xview::test
