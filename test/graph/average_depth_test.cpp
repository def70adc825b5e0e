// SPDX-License-Identifier: BSD-3-Clause
#include "xview/graph/average_depth.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "xview/types/random.h"

namespace xview {

using namespace graph;

namespace {

constexpr double kSigma = 0.002;  ///< of inverse depth [1/m]
constexpr double kGround_m = 35;
constexpr int kWidth = 80, kHeight = 60;

/// What a camera that looks along z sees from `x_m` of a plane across its view.
Frame planeFrom(double x_m, double plane_m, std::uint64_t seed) {
  Frame frame;
  frame.camera.width = kWidth, frame.camera.height = kHeight;
  frame.camera.fx = frame.camera.fy = 40;
  frame.camera.cx = 0.5 * (kWidth - 1), frame.camera.cy = 0.5 * (kHeight - 1);
  frame.T_odom_sensor.translation().x() = x_m;
  frame.depth = DepthImage(kWidth, kHeight);
  Random random(seed);
  for (float& z : frame.depth.pixels)
    z = static_cast<float>(1 / (1 / plane_m + kSigma * random.normal()));
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
  EXPECT_NEAR(ranges.at(40, 30), planar.at(40, 30), 0.6);
}

TEST(AverageDepth, MedianIsOfWhatWasMeasured) {
  DepthImage depth(5, 1);
  depth.pixels = {0, 3, NAN, 1, 2};
  EXPECT_EQ(medianDepth(depth), 2);
  EXPECT_EQ(medianDepth(DepthImage(5, 1)), 0);
}

}  // namespace
}  // namespace xview
