// SPDX-License-Identifier: BSD-3-Clause
#include "place/smooth_depth.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "base/random.h"

namespace xview {

namespace {

constexpr double kSigma = 0.002;  ///< of inverse depth [1/m]
constexpr double kGood_m = 0.05;
constexpr int kWidth = 96, kHeight = 64;

using InverseDepth = std::function<double(int u, int v)>;

DepthImage imageOf(const InverseDepth& truth, double sigma, std::uint64_t seed = 7) {
  DepthImage depth(kWidth, kHeight);
  Random random(seed);
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

constexpr double kGround_m = 35;

/// What a camera that looks along z sees from `x_m` of a plane across its view.
Frame planeFrom(double x_m, double plane_m, std::uint64_t seed) {
  Frame frame;
  frame.camera.width = kWidth, frame.camera.height = kHeight;
  frame.camera.fx = frame.camera.fy = 40;
  frame.camera.cx = 0.5 * (kWidth - 1), frame.camera.cy = 0.5 * (kHeight - 1);
  frame.T_odom_sensor.translation().x() = x_m;
  frame.depth = imageOf([&](int, int) { return 1 / plane_m; }, kSigma, seed);
  return frame;
}

std::vector<Frame> planesAround(double plane_m) {
  std::vector<Frame> frames;
  for (int i = 1; i <= 4; ++i) {
    frames.push_back(planeFrom(2 * i, plane_m, static_cast<std::uint64_t>(10 + i)));
    frames.push_back(planeFrom(-2 * i, plane_m, static_cast<std::uint64_t>(20 + i)));
  }
  return frames;
}

std::vector<const Frame*> pointersTo(const std::vector<Frame>& frames) {
  std::vector<const Frame*> pointers;
  for (const Frame& frame : frames) pointers.push_back(&frame);
  return pointers;
}

/// Mean error of the inverse depth, and its spread.
std::pair<double, double> errorsOf(const DepthImage& depth, double plane_m) {
  double sum = 0, squares = 0;
  for (const float z : depth.pixels) {
    const double error = 1 / z - 1 / plane_m;
    sum += error, squares += error * error;
  }
  const auto n = static_cast<double>(depth.pixels.size());
  return {sum / n, std::sqrt(squares / n - sum * sum / (n * n))};
}

TEST(AverageDepth, NineLooksHaveLittleMoreThanAThirdOfTheNoiseOfOne) {
  const Frame frame = planeFrom(0, kGround_m, 1);
  const DepthImage averaged = averageDepth(frame, pointersTo(planesAround(kGround_m)), kSigma);
  const auto [mean, spread] = errorsOf(averaged, kGround_m);
  EXPECT_NEAR(mean, 0, 0.05 * kSigma);
  EXPECT_LT(spread, 0.5 * kSigma);
  EXPECT_GT(spread, kSigma / 3);
}

TEST(AverageDepth, ThingsInFrontOfWhatIsSeenHereHaveNoPart) {
  const Frame frame = planeFrom(0, kGround_m, 1);
  const DepthImage averaged = averageDepth(frame, pointersTo(planesAround(12)), kSigma);
  EXPECT_EQ(averaged.pixels, frame.depth.pixels);
}

TEST(AverageDepth, PixelsWithoutDepthStayWithout) {
  Frame frame = planeFrom(0, kGround_m, 1);
  for (int u = 0; u < kWidth; ++u) frame.depth.at(u, 30) = 0;
  const DepthImage averaged = averageDepth(frame, pointersTo(planesAround(kGround_m)), kSigma);
  for (int u = 0; u < kWidth; ++u) EXPECT_EQ(averaged.at(u, 30), 0);
}

TEST(AverageDepth, RangesAreAveragedAsRanges) {
  Frame frame = planeFrom(0, kGround_m, 1);
  std::vector<Frame> others = planesAround(kGround_m);
  const auto toRanges = [](Frame& f) {
    for (int v = 0; v < kHeight; ++v)
      for (int u = 0; u < kWidth; ++u)
        f.depth.at(u, v) = static_cast<float>(f.camera.unproject(u, v, f.depth.at(u, v)).norm());
    f.camera.depth_is_range = true;
  };
  const double longer = frame.camera.unproject(0, 0, 1).norm();  // than the depth of the corner
  const DepthImage planar = averageDepth(frame, pointersTo(others), kSigma);
  toRanges(frame);
  for (Frame& other : others) toRanges(other);
  const DepthImage ranges = averageDepth(frame, pointersTo(others), kSigma);
  EXPECT_NEAR(ranges.at(0, 0), longer * planar.at(0, 0), 2);
  EXPECT_NEAR(ranges.at(48, 32), planar.at(48, 32), 0.6);
}

TEST(AverageDepth, MedianIsOfWhatWasMeasured) {
  DepthImage depth(5, 1);
  depth.pixels = {0, 3, NAN, 1, 2};
  EXPECT_EQ(medianDepth(depth), 2);
  EXPECT_EQ(medianDepth(DepthImage(5, 1)), 0);
}

}  // namespace
}  // namespace xview
