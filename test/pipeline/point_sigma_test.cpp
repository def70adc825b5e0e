// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/point_sigma.h"

#include <gtest/gtest.h>

#include <limits>

namespace xview {
namespace {

/// Points 10, 20 and 30 m from the sensor, known to `inverse_depth_sigma` times the square of that.
FrameDigest frameOfThree(double inverse_depth_sigma) {
  FrameDigest frame;
  frame.cloud.origin = {100, 0, 0};
  frame.T_odom_sensor.translation() = frame.cloud.origin;
  for (const float range : {10.f, 20.f, 30.f}) {
    frame.cloud.points.push_back(Point(range, 0, 0, 7));
    frame.cloud.points.back().sigma = static_cast<float>(inverse_depth_sigma * range * range);
  }
  return frame;
}

TEST(KnownPoints, AreThoseOfASmallError) {
  LabelledCloud cloud;
  EXPECT_EQ(appendKnownPoints(frameOfThree(1e-3), 0.5, cloud), 2u);
  EXPECT_FLOAT_EQ(cloud.points[0].sigma, 0.1f);
  EXPECT_FLOAT_EQ(cloud.points[1].sigma, 0.4f) << "that of 0.9 m is left out";
}

TEST(KnownPoints, RangeIsThatFromTheSensor) {
  FrameDigest frame = frameOfThree(0);
  EXPECT_FLOAT_EQ(rangeOf(frame, 1), 20);
  frame.sensor = Sensor::cloud;
  EXPECT_EQ(rangeOf(frame, 1), 0) << "a cloud does not tell";
}

TEST(KnownPoints, KeepTheirPlacesAndClasses) {
  LabelledCloud cloud;
  cloud.origin = {90, 5, 0};
  EXPECT_EQ(appendKnownPoints(frameOfThree(0), 0.5, cloud), 3u);
  EXPECT_EQ(appendKnownPoints(frameOfThree(0), 0.5, cloud), 3u);
  ASSERT_EQ(cloud.size(), 6u);
  EXPECT_EQ(cloud.position(4), Eigen::Vector3d(120, 0, 0));
  EXPECT_EQ(cloud.points[4].label, 7u);
}

TEST(KnownPoints, AreNotThoseWhoseErrorIsNoNumber) {
  LabelledCloud cloud;
  EXPECT_EQ(appendKnownPoints(frameOfThree(std::numeric_limits<double>::quiet_NaN()), 0.5, cloud),
            0u);
}

}  // namespace
}  // namespace xview
