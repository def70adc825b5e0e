// SPDX-License-Identifier: BSD-3-Clause
#include "xview/graph/smooth_depth.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "xview/types/random.h"

namespace xview {

using namespace graph;

namespace {

constexpr double kSigma = 0.002;  ///< of inverse depth [1/m]
constexpr double kGood_m = 0.05;
constexpr int kWidth = 96, kHeight = 64;

using InverseDepth = std::function<double(int u, int v)>;

DepthImage imageOf(const InverseDepth& truth, double sigma) {
  DepthImage depth(kWidth, kHeight);
  Random random(7);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u)
      depth.at(u, v) = static_cast<float>(1 / (truth(u, v) + sigma * random.normal()));
  }
  return depth;
}

LabelImage oneLabel() { return LabelImage(kWidth, kHeight, 3); }

DepthImage smoothed(DepthImage depth, const LabelImage& labels, double sigma = kSigma) {
  smoothDepth(depth, labels, sigma, kGood_m);
  return depth;
}

double slanted(int u, int v) { return 0.03 + 0.0001 * u + 0.0002 * v; }

/// Root of the mean square of errors of the inverse depth, in units of the noise.
double errorOf(const DepthImage& depth, const InverseDepth& truth, int first_u = 0,
               int last_u = kWidth) {
  double sum = 0;
  int n = 0;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = first_u; u < last_u; ++u, ++n)
      sum += std::pow((1 / depth.at(u, v) - truth(u, v)) / kSigma, 2);
  }
  return std::sqrt(sum / n);
}

double meanTooFar(const DepthImage& depth, const InverseDepth& truth) {
  double sum = 0;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) sum += depth.at(u, v) - 1 / truth(u, v);
  }
  return sum / (kWidth * kHeight);
}

TEST(SmoothDepth, FindsASlantedPlaneUnderNoise) {
  const DepthImage noisy = imageOf(slanted, kSigma);
  EXPECT_GT(errorOf(noisy, slanted), 0.9);
  EXPECT_LT(errorOf(smoothed(noisy, oneLabel()), slanted), 0.2);
}

TEST(SmoothDepth, TakesAwayThatNoisyDepthsAreTooFarOnAverage) {
  const DepthImage noisy = imageOf(slanted, kSigma);
  EXPECT_GT(meanTooFar(noisy, slanted), 0.03);
  EXPECT_LT(std::abs(meanTooFar(smoothed(noisy, oneLabel()), slanted)), 0.01);
}

TEST(SmoothDepth, KeepsAnEdgeWithinAClass) {
  const auto step = [](int u, int) { return u < 43 ? 0.04 : 0.06; };
  const DepthImage smooth = smoothed(imageOf(step, kSigma), oneLabel());
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u)
      ASSERT_LT(std::abs(1 / smooth.at(u, v) - step(u, v)), 5 * kSigma) << u << " " << v;
  }
  EXPECT_LT(errorOf(smooth, step, 0, 40), 0.3);
}

TEST(SmoothDepth, KeepsAStepBelowTheNoiseWhereTheClassChanges) {
  const auto step = [](int u, int) { return u < 48 ? 0.04 : 0.04 + kSigma; };
  LabelImage labels = oneLabel();
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 48; u < kWidth; ++u) labels.at(u, v) = 4;
  }
  EXPECT_LT(errorOf(smoothed(imageOf(step, kSigma), labels), step, 40, 56), 0.25);
}

TEST(SmoothDepth, LeavesWhatNoPlaneExplains) {
  Random leaves(3);
  const auto crown = [&](int, int) { return 0.05 + 0.02 * leaves.uniform(); };
  const DepthImage rough = imageOf(crown, 0);
  EXPECT_EQ(smoothed(rough, oneLabel()).pixels, rough.pixels);
}

TEST(SmoothDepth, LeavesWhatIsKnownWell) {
  const auto near = [](int, int) { return 0.25; };  // sigma = 4^2 * 0.002 = 0.03 m
  const DepthImage noisy = imageOf(near, kSigma);
  EXPECT_EQ(smoothed(noisy, oneLabel()).pixels, noisy.pixels);
}

TEST(SmoothDepth, NeitherFillsNorUsesPixelsWithoutDepth) {
  DepthImage noisy = imageOf(slanted, kSigma);
  const float infinite = std::numeric_limits<float>::infinity();
  for (int k = 0; k < kHeight; ++k) noisy.at(k, k) = k % 2 ? 0.F : infinite;
  const DepthImage smooth = smoothed(noisy, oneLabel());
  for (int k = 0; k < kHeight; ++k) EXPECT_EQ(smooth.at(k, k), k % 2 ? 0.F : infinite);
  EXPECT_NEAR(1 / smooth.at(30, 31), slanted(30, 31), kSigma);
}

TEST(SmoothDepth, DoesNothingWithoutNoise) {
  const DepthImage noisy = imageOf(slanted, kSigma);
  EXPECT_EQ(smoothed(noisy, oneLabel(), 0).pixels, noisy.pixels);
  DepthImage none;
  smoothDepth(none, LabelImage(), kSigma, kGood_m);
  EXPECT_TRUE(none.empty());
}

TEST(SmoothDepth, TakesImagesOfAnySize) {
  for (const int side : {1, 3, 5, 13}) {
    DepthImage depth(side, 1, 30.F);
    smoothDepth(depth, LabelImage(side, 1, 3), kSigma, kGood_m);
    for (const float z : depth.pixels) EXPECT_NEAR(z, 30, 1e-3);
  }
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
}  // namespace xview
