// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/point_sigma.h"

#include <gtest/gtest.h>

#include <limits>

namespace xview {
namespace {

/// Points 10, 20 and 30 m away on the x axis of a cloud whose origin is at x = 100 m.
FrameDigest frameOfThree(double inverse_depth_sigma) {
  FrameDigest frame;
  frame.inverse_depth_sigma = inverse_depth_sigma;
  frame.cloud.origin = {100, 0, 0};
  for (const float range : {10.f, 20.f, 30.f}) {
    frame.cloud.points.push_back(pcl::PointXYZL(range, 0, 0, 7));
    frame.cloud.ranges.push_back(range);
  }
  return frame;
}

TEST(KnownPoints, DepthErrorGrowsWithTheSquareOfTheRange) {
  LabelledCloud cloud;
  std::vector<float> sigmas;
  EXPECT_EQ(appendKnownPoints(frameOfThree(1e-3), 0.5, cloud, sigmas), 2u);
  EXPECT_EQ(sigmas, (std::vector<float>{0.1f, 0.4f})) << "that of 0.9 m is left out";
}

TEST(KnownPoints, KeepTheirPlacesAndClasses) {
  LabelledCloud cloud;
  cloud.origin = {90, 5, 0};
  std::vector<float> sigmas;
  EXPECT_EQ(appendKnownPoints(frameOfThree(0), 0.5, cloud, sigmas), 3u);
  EXPECT_EQ(appendKnownPoints(frameOfThree(0), 0.5, cloud, sigmas), 3u);
  ASSERT_EQ(cloud.size(), 6u);
  EXPECT_EQ(cloud.position(4), Eigen::Vector3d(120, 0, 0));
  EXPECT_EQ(cloud.points[4].label, 7u);
}

TEST(KnownPoints, AreNotThoseWhoseErrorIsNoNumber) {
  LabelledCloud cloud;
  std::vector<float> sigmas;
  EXPECT_EQ(
      appendKnownPoints(frameOfThree(std::numeric_limits<double>::quiet_NaN()), 0.5, cloud, sigmas),
      0u);
}

}  // namespace
}  // namespace xview
