// SPDX-License-Identifier: BSD-3-Clause
#include "place/blobs.h"

#include <gtest/gtest.h>

#include "scenes.h"
#include "xview/base/error.h"

namespace xview {

namespace {

using namespace test;
using Edges = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// A frame of the size the options speak of, all sky, with boxes of things at 10 m.
Frame emptySky() {
  Frame frame = flatFrame(640, 480, kSky, 0);
  frame.number = 17;
  return frame;
}

void put(Frame& frame, int x0, int y0, int width, int height, std::uint16_t label,
         float depth_m = 10) {
  for (int y = y0; y < y0 + height; ++y) {
    for (int x = x0; x < x0 + width; ++x) {
      frame.label.at(x, y) = label;
      frame.depth.at(x, y) = depth_m;
    }
  }
}

TEST(ImageBlobs, AreAtTheMedianDepthOfTheirCentroid) {
  Frame frame = emptySky();
  put(frame, 100, 200, 41, 21, kCar, 10);
  put(frame, 100, 200, 41, 5, kCar, 40);  // seen through the windows
  frame.depth.at(120, 210) = 0;
  Random random(1);
  frame.T_odom_sensor = randomPose(random);
  const ImageBlobs found = extractImageBlobs(frame, townLabels(), 50);
  ASSERT_EQ(found.blobs.size(), 1u);
  const Eigen::Vector3d p_sensor((120 - 319.5) / 320 * 10, (210 - 239.5) / 320 * 10, 10);
  EXPECT_LT((found.blobs[0].position - frame.T_odom_sensor * p_sensor).norm(), 1e-6);
  EXPECT_EQ(found.blobs[0].label, kCar);
  EXPECT_EQ(found.blobs[0].points, 41u * 21u - 1);
  EXPECT_EQ(found.blobs[0].first_frame, 17);
}

TEST(ImageBlobs, HaveCovarianceAndBoundsOfTheirPoints) {
  Frame frame = emptySky();
  put(frame, 300, 220, 40, 40, kCar, 32);  // 0.1 m per pixel, in the middle of the image
  const ImageBlobs found = extractImageBlobs(frame, townLabels(), 50);
  ASSERT_EQ(found.blobs.size(), 1u);
  EXPECT_LT((found.blobs[0].min - Eigen::Vector3d(-1.95, -1.95, 32)).norm(), 1e-4);
  EXPECT_LT((found.blobs[0].max - Eigen::Vector3d(1.95, 1.95, 32)).norm(), 1e-4);
  const Eigen::Vector3d variances(1.3325, 1.3325, 0);  // 0.01 * (40^2 - 1) / 12
  EXPECT_LT((found.blobs[0].covariance - Eigen::Matrix3d(variances.asDiagonal())).norm(), 1e-3);
}

TEST(ImageBlobs, ConnectContoursUpToTheDistance) {
  Frame frame = emptySky();
  put(frame, 100, 100, 30, 30, kCar);    // 0
  put(frame, 139, 100, 30, 30, kBench);  // 1: columns 129 and 139 are 10 px apart
  put(frame, 179, 100, 30, 30, kCar);    // 2: columns 168 and 179 are 11 px apart
  put(frame, 100, 135, 30, 30, kBench);  // 3: 6 px below the first; corner to corner 11.7 px from 1
  const ImageBlobs found = extractImageBlobs(frame, townLabels(), 50);
  ASSERT_EQ(found.blobs.size(), 4u);
  EXPECT_EQ(found.edges, (Edges{{0, 1}, {0, 3}}));
}

TEST(ImageBlobs, OfTheSameSceneAtHalfSizeAreTheSame) {
  Frame large = emptySky();
  put(large, 100, 100, 40, 20, kCar);
  put(large, 148, 100, 40, 20, kBench);
  put(large, 300, 300, 10, 10, kPole);  // too small
  Frame half = flatFrame(320, 240, kSky, 0);
  put(half, 50, 50, 20, 10, kCar);
  put(half, 74, 50, 20, 10, kBench);
  put(half, 150, 150, 5, 5, kPole);
  const ImageBlobs a = extractImageBlobs(large, townLabels(), 50);
  const ImageBlobs b = extractImageBlobs(half, townLabels(), 50);
  ASSERT_EQ(a.blobs.size(), 2u);
  ASSERT_EQ(b.blobs.size(), 2u);
  EXPECT_EQ(a.edges, b.edges);
  EXPECT_EQ(a.edges.size(), 1u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_LT((a.blobs[i].position - b.blobs[i].position).norm(), 0.02);
  }
}

TEST(ImageBlobs, SeparateInstances) {
  Frame frame = emptySky();
  put(frame, 100, 100, 60, 30, kCar);
  frame.instance = LabelImage(640, 480, 0);
  for (int y = 100; y < 130; ++y) {
    for (int x = 130; x < 160; ++x) frame.instance.at(x, y) = 5;
  }
  const ImageBlobs found = extractImageBlobs(frame, townLabels(), 50);
  ASSERT_EQ(found.blobs.size(), 2u);
  EXPECT_EQ(found.blobs[0].instance, 0u);
  EXPECT_EQ(found.blobs[1].instance, 5u);
  EXPECT_EQ(found.edges, (Edges{{0, 1}}));
}

TEST(ImageBlobs, SeparateInstancesOfTheClassesAskedFor) {
  Frame frame = emptySky();
  put(frame, 100, 100, 60, 30, kCar);
  put(frame, 300, 100, 60, 30, kBench);
  frame.instance = LabelImage(640, 480, 0);
  for (int y = 100; y < 130; ++y) {
    for (int x = 130; x < 330; ++x) frame.instance.at(x, y) = 5;
  }
  BlobOptions options;
  for (const auto& [instances, blobs] :
       {std::pair<const char*, std::size_t>{"all", 4}, {"dynamic", 3}, {"none", 2}}) {
    options.instances = instances;
    EXPECT_EQ(extractImageBlobs(frame, townLabels(), 50, options).blobs.size(), blobs) << instances;
  }
  options.min_share = 30.0 * 60 / (640 * 480);
  EXPECT_EQ(extractImageBlobs(frame, townLabels(), 50, options).blobs.size(), 2u);
  options.min_share *= 1.01;
  EXPECT_EQ(extractImageBlobs(frame, townLabels(), 50, options).blobs.size(), 0u);
}

TEST(ImageBlobs, WithoutDepthInRangeAreDroppedAndLeaveNoEdge) {
  Frame frame = emptySky();
  put(frame, 100, 100, 30, 30, kCar, 0);
  put(frame, 130, 100, 30, 30, kBench, 80);
  put(frame, 160, 100, 30, 30, kCar, 10);
  const ImageBlobs found = extractImageBlobs(frame, townLabels(), 50);
  ASSERT_EQ(found.blobs.size(), 1u);
  EXPECT_TRUE(found.edges.empty());
}

TEST(ImageBlobs, RespectDepthAlongTheRay) {
  Frame frame = emptySky();
  frame.camera.depth_is_range = true;
  put(frame, 0, 0, 40, 40, kCar, 10);
  const ImageBlobs found = extractImageBlobs(frame, townLabels(), 50);
  ASSERT_EQ(found.blobs.size(), 1u);
  EXPECT_NEAR(found.blobs[0].position.norm(), 10, 1e-6);
}

TEST(ImageBlobs, OfNothingAreNone) {
  EXPECT_TRUE(extractImageBlobs(emptySky(), townLabels(), 50).blobs.empty());
  EXPECT_TRUE(extractImageBlobs(Frame(), townLabels(), 50).blobs.empty());
}

TEST(ImageBlobs, RefuseImagesOfDifferentSize) {
  Frame frame = emptySky();
  frame.label = LabelImage(640, 479, kCar);
  EXPECT_THROW(extractImageBlobs(frame, townLabels(), 50), Error);
}

}  // namespace
}  // namespace xview
