// SPDX-License-Identifier: BSD-3-Clause
#include "sim/route.h"

#include <gtest/gtest.h>

#include "base/pose.h"

namespace xview {
namespace {

TownOptions townOf(std::uint64_t seed) {
  TownOptions options;
  options.seed = seed;
  return options;
}

TEST(Route, BothLanesStayOnTheRoad) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const StreetNetwork network = makeStreets(townOf(seed));
    const StreetField field(network);
    const Polyline drive = planDrive(network, 400, seed);
    for (const double lane : {-1.55, -1.15, 1.4}) {
      for (const Eigen::Vector2d& p : shifted(drive, lane)) {
        ASSERT_LT(field.toRoad(p), -0.3) << "seed " << seed << " lane " << lane;
      }
    }
  }
}

TEST(Route, HasTheWantedLengthAlsoWhenTheTownIsSmaller) {
  TownOptions options = townOf(1);
  options.blocks_x = options.blocks_y = 1;
  for (const double length : {10.0, 300.0, 5000.0}) {
    EXPECT_NEAR(ArcLength(planDrive(makeStreets(options), length, 1)).length(), length,
                0.02 * length + 1);
  }
}

TEST(Route, NoParkedCarStandsInTheWay) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    TownOptions options = townOf(seed);
    options.car_density = 1;
    const Town town = makeTown(options);
    const TriangleMesh traffic = makeTraffic(town, seed);
    const Polyline drive = shifted(planDrive(town.network, 200, seed), -1.4);
    for (const Eigen::Vector3f& v : traffic.vertices) {
      for (const Eigen::Vector2d& p : drive) {
        ASSERT_GT((v.head<2>().cast<double>() - p).norm(), 0.3) << "seed " << seed;
      }
    }
  }
}

TEST(Route, PosesAreEvenlySpacedAndLookAlongTheDrive) {
  const Relief relief(1, 3);
  Polyline line;
  for (int i = 0; i <= 100; ++i) line.push_back({0, 1.0 * i});
  const auto poses = bodyPoses(line, 2, Mount(), relief, 1);
  ASSERT_EQ(poses.size(), 51u);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_NEAR(poses[i].translation().y(), 2.0 * static_cast<double>(i), 0.3);
    EXPECT_GT(poses[i].linear()(1, 0), 0.99);  // x of the body looks north
    EXPECT_GT(poses[i].linear()(2, 2), 0.99);
    EXPECT_TRUE(isRigid(poses[i].matrix(), 1e-9));
  }
  const Eigen::Matrix3d optical = opticalPose(poses[10]).linear();
  EXPECT_LT((optical.col(2) - poses[10].linear().col(0)).norm(), 1e-12);  // z looks ahead
  EXPECT_LT((optical.col(1) + poses[10].linear().col(2)).norm(), 1e-12);  // y looks down
}

std::vector<Eigen::Isometry3d> straightPoses(int count) {
  Polyline line;
  for (int i = 0; i < count; ++i) line.push_back({2.0 * i, 0.5 * i});
  return bodyPoses(line, 2, Mount(), Relief(3, 3), 5);
}

TEST(Odometry, WithoutDriftIsTheTruthInAnotherUprightFrame) {
  const auto truth = straightPoses(60);
  const auto odometry = asOdometry(truth, 0, 4);
  const Eigen::Isometry3d T_odom_world = odometry[0] * truth[0].inverse();
  EXPECT_LT((T_odom_world.linear().col(2) - Eigen::Vector3d::UnitZ()).norm(), 1e-9);
  EXPECT_GT(T_odom_world.translation().norm(), 1);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    EXPECT_LT(((T_odom_world * truth[i]).matrix() - odometry[i].matrix()).norm(), 1e-9);
  }
}

TEST(Odometry, FrameDependsOnTheSeed) {
  const auto truth = straightPoses(3);
  EXPECT_GT(
      (asOdometry(truth, 0, 4)[0].translation() - asOdometry(truth, 0, 5)[0].translation()).norm(),
      1);
}

TEST(Odometry, DriftGrowsToAboutItsShareOfTheDistance) {
  const auto truth = straightPoses(51);
  double sum = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto odometry = asOdometry(truth, 0.01, seed);
    const Eigen::Isometry3d moved = truth[0].inverse() * truth.back();
    const Eigen::Isometry3d measured = odometry[0].inverse() * odometry.back();
    const double share =
        (moved.translation() - measured.translation()).norm() / moved.translation().norm();
    EXPECT_GT(share, 0.005);
    EXPECT_LT(share, 0.02);
    sum += share;
    // Gravity is known: the height of each axis stays.
    EXPECT_LT((odometry.back().linear().row(2) - truth.back().linear().row(2)).norm(), 1e-9);
  }
  EXPECT_NEAR(sum / 20, 0.01, 0.002);
}

TEST(Odometry, OfNothingIsNothing) { EXPECT_TRUE(asOdometry({}, 0.01, 1).empty()); }

}  // namespace
}  // namespace xview
