// SPDX-License-Identifier: BSD-3-Clause
#include "place/lift.h"

#include <gtest/gtest.h>

#include <limits>

#include "place/smooth_depth.h"
#include "scenes.h"
#include "xview/base/error.h"

namespace xview {

namespace {

using namespace test;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

TEST(Lift, PutsAPixelWhereItsRayAndDepthSay) {
  Frame frame = flatFrame(8, 6, kVoid, 0);
  frame.camera.fx = 100;
  frame.camera.fy = 50;
  frame.camera.cx = 3;
  frame.camera.cy = 2;
  frame.depth.at(5, 4) = 20;
  frame.label.at(5, 4) = kCar;
  Random random(1);
  frame.T_odom_sensor = randomPose(random);
  const LabelledCloud cloud = lift(frame, townLabels(), {});
  ASSERT_EQ(cloud.size(), 1u);
  const Eigen::Vector3d p_sensor(20 * 0.02, 20 * 0.04, 20);
  EXPECT_LT((cloud.position(0) - frame.T_odom_sensor * p_sensor).norm(), 1e-4);
  EXPECT_EQ(cloud.points[0].label, kCar);
}

TEST(Lift, DepthAlongTheRayGivesTheSameRangeEverywhere) {
  Frame frame = flatFrame(32, 24, kBuilding, 10);
  frame.camera.depth_is_range = true;
  const LabelledCloud cloud = lift(frame, townLabels(), {});
  ASSERT_EQ(cloud.size(), 32u * 24u);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    EXPECT_NEAR(cloud.position(i).norm(), 10, 1e-4);
  }
}

TEST(Lift, IsEquivariantToThePose) {
  Random random(2);
  Frame frame = flatFrame(16, 12, kRoad, 5);
  for (float& z : frame.depth.pixels) z = static_cast<float>(random.uniform(1, 40));
  const LabelledCloud still = lift(frame, townLabels(), {});
  frame.T_odom_sensor = randomPose(random);
  const LabelledCloud moved = lift(frame, townLabels(), {});
  ASSERT_EQ(moved.size(), still.size());
  for (std::size_t i = 0; i < moved.size(); ++i) {
    EXPECT_LT((moved.position(i) - frame.T_odom_sensor * still.position(i)).norm(), 1e-4);
  }
}

TEST(Lift, KeepsMillimetresAtMapProjectionCoordinates) {
  Frame frame = flatFrame(16, 12, kRoad, 5);
  frame.T_odom_sensor.translation() = Eigen::Vector3d(500000.123, 4649776.225, 87.5);
  const LabelledCloud cloud = lift(frame, townLabels(), {});
  EXPECT_EQ(cloud.origin, Eigen::Vector3d(500000, 4649776, 88));
  const Eigen::Vector3d p_sensor(-7.5 * 5 / 8, -5.5 * 5 / 8, 5);
  EXPECT_LT((cloud.position(0) - (frame.T_odom_sensor * p_sensor)).norm(), 1e-5);
}

TEST(Lift, CountsEveryMeasurementOnce) {
  Frame frame = flatFrame(10, 10, kRoad, 5);
  frame.depth.at(0, 0) = 0;
  frame.depth.at(1, 0) = kNaN;
  frame.depth.at(2, 0) = kInfinity;
  frame.depth.at(3, 0) = -1;
  frame.depth.at(4, 0) = 0.1f;
  frame.depth.at(5, 0) = 51;
  frame.label.at(6, 0) = kSky;
  frame.label.at(7, 0) = 999;
  frame.label.at(8, 0) = kVoid;
  LiftCounts counts;
  const LabelledCloud cloud = lift(frame, townLabels(), {}, &counts);
  EXPECT_EQ(counts.no_depth, 4u);
  EXPECT_EQ(counts.out_of_range, 2u);
  EXPECT_EQ(counts.ignored_class, 3u);
  EXPECT_EQ(counts.lifted, 91u);
  EXPECT_EQ(cloud.size(), 91u);
  EXPECT_EQ(cloud.points.width, 91u);
}

TEST(Lift, RespectsTheRangesOfTheCamera) {
  Frame frame = flatFrame(20, 1, kRoad, 10);
  frame.camera.min_range_m = 5;
  frame.camera.max_range_m = 20;
  frame.depth.at(9, 0) = 4.9f;
  frame.depth.at(10, 0) = 20.1f;
  LiftCounts counts;
  EXPECT_EQ(lift(frame, townLabels(), {}, &counts).size(), 18u);
  EXPECT_EQ(counts.out_of_range, 2u);
  EXPECT_EQ(maxRange(frame, {}), 20);
  frame.camera.max_range_m = 1000;
  EXPECT_EQ(maxRange(frame, {}), LiftOptions().max_range_m);
}

TEST(Lift, LooksFurtherFromTheAir) {
  LiftOptions options;
  Frame frame = flatFrame(20, 20, kRoad, 60);
  EXPECT_EQ(lift(frame, townLabels(), options).size(), 400u);
  for (int i = 0; i < 39; ++i) frame.depth.pixels[static_cast<std::size_t>(i)] = 10;
  EXPECT_EQ(lift(frame, townLabels(), options).size(), 400u);  // 9.75 % are near
  frame.depth.pixels[39] = 10;
  EXPECT_EQ(lift(frame, townLabels(), options).size(), 40u);  // a tenth is near: on the ground
}

TEST(Lift, BringsInstancesAlong) {
  Frame frame = flatFrame(4, 4, kCar, 5);
  frame.instance = LabelImage(4, 4, 3);
  frame.instance.at(3, 3) = 9;
  frame.depth.at(0, 0) = 0;
  const LabelledCloud cloud = lift(frame, townLabels(), {});
  ASSERT_EQ(cloud.size(), 15u);
  EXPECT_EQ(cloud.points.front().instance, 3u);
  EXPECT_EQ(cloud.points.back().instance, 9u);
}

/// The noise of inverse depth makes errors that grow with the square of the range.
TEST(Lift, TellsHowWellPointsOfACameraAreKnown) {
  Frame frame = flatFrame(80, 60, kCar, 20);
  EXPECT_EQ(inverseDepthNoise(frame.depth), 0);
  constexpr double kNoise = 0.002;
  Random random(1);
  for (float& z : frame.depth.pixels) z = static_cast<float>(1 / (0.05 + kNoise * random.normal()));
  LabelledCloud cloud = lift(frame, townLabels(), {});
  setSigmas(inverseDepthNoise(frame.depth), frame.T_odom_sensor.translation(), cloud);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const double squared = (cloud.position(i) - frame.T_odom_sensor.translation()).squaredNorm();
    EXPECT_NEAR(cloud.points[i].sigma / squared, kNoise, 0.2 * kNoise);
  }
  Frame saved;
  saved.sensor = Sensor::cloud;
  saved.cloud = cloud;
  EXPECT_EQ(lift(saved, townLabels(), {}).points[5].sigma, cloud.points[5].sigma);
}

TEST(Lift, OfAScanGatesByRangeAndSkipsBadPoints) {
  Frame frame;
  frame.sensor = Sensor::lidar;
  frame.cloud = cloudOf({{10, 0, 0}, {0, 59, 0}, {0, 0, 61}, {0.1f, 0, 0}, {kNaN, 0, 0}}, kRoad);
  frame.cloud.points.push_back(Point(5, 5, 5, kVoid));
  Random random(4);
  frame.T_odom_sensor = randomPose(random);
  LiftCounts counts;
  const LabelledCloud cloud = lift(frame, townLabels(), {}, &counts);
  ASSERT_EQ(cloud.size(), 2u);
  EXPECT_LT((cloud.position(1) - frame.T_odom_sensor * Eigen::Vector3d(0, 59, 0)).norm(), 1e-4);
  EXPECT_EQ(counts.out_of_range, 2u);
  EXPECT_EQ(counts.no_depth, 1u);
  EXPECT_EQ(counts.ignored_class, 1u);
}

TEST(Lift, OfASavedCloudKeepsPointsOfAnyRangeAndItsOrigin) {
  Frame frame;
  frame.sensor = Sensor::cloud;
  frame.cloud = cloudOf({{1, 2, 3}, {900, 0, 0}}, kRoad, Eigen::Vector3d(500000.5, 4649776, 10));
  const LabelledCloud cloud = lift(frame, townLabels(), {});
  ASSERT_EQ(cloud.size(), 2u);
  EXPECT_LT((cloud.position(0) - Eigen::Vector3d(500001.5, 4649778, 13)).norm(), 1e-6);
  EXPECT_LT((cloud.position(1) - Eigen::Vector3d(500900.5, 4649776, 10)).norm(), 1e-6);
}

TEST(Lift, OfNothingIsEmpty) {
  EXPECT_TRUE(lift(flatFrame(4, 4, kVoid, 5), townLabels(), {}).empty());
  EXPECT_TRUE(lift(flatFrame(4, 4, kRoad, 0), townLabels(), {}).empty());
  EXPECT_TRUE(lift(flatFrame(4, 4, kRoad, 5), LabelSet(), {}).empty());
  Frame scan;
  scan.sensor = Sensor::lidar;
  EXPECT_TRUE(lift(scan, townLabels(), {}).empty());
}

TEST(Lift, RefusesImagesOfDifferentSizeAndBrokenCameras) {
  Frame frame = flatFrame(4, 4, kRoad, 5);
  frame.label = LabelImage(4, 3, kRoad);
  EXPECT_THROW(lift(frame, townLabels(), {}), Error);
  frame = flatFrame(4, 4, kRoad, 5);
  frame.instance = LabelImage(5, 4);
  EXPECT_THROW(lift(frame, townLabels(), {}), Error);
  frame = flatFrame(4, 4, kRoad, 5);
  frame.camera.fx = 0;
  EXPECT_THROW(lift(frame, townLabels(), {}), Error);
  frame = flatFrame(4, 4, kRoad, 5);
  frame.T_odom_sensor.translation().x() = kNaN;
  EXPECT_THROW(lift(frame, townLabels(), {}), Error);
}

}  // namespace
}  // namespace xview
