// SPDX-License-Identifier: BSD-3-Clause
#include "../../src/pose/registration.h"

#include <gtest/gtest.h>

#include <limits>
#include <map>

#include "support/label_sets.h"

namespace xview::pose {
namespace {

constexpr std::uint32_t kRoad = 1, kWall = 2, kPole = 3, kCar = 4;

LabelSet streetLabels() {
  return test::labelSetOf("street", {{kRoad, "road", Role::surface, Kind::road},
                                     {kWall, "building", Role::surface, Kind::building},
                                     {kPole, "pole", Role::object, Kind::pole},
                                     {kCar, "vehicle", Role::dynamic, Kind::vehicle}});
}

/// So many points of each class, one class after the other, x counting them.
LabelledCloud cloudOf(const std::map<std::uint32_t, int>& counts) {
  LabelledCloud cloud;
  for (const auto& [label, count] : counts) {
    for (int i = 0; i < count; ++i)
      cloud.points.emplace_back(static_cast<float>(cloud.points.size()), 0.F, 0.F, label);
  }
  return cloud;
}

std::vector<QueryPoint> chosenOf(const LabelledCloud& cloud, int max_points) {
  const std::vector<Eigen::Isometry3d> poses{Eigen::Isometry3d::Identity()};
  return choosePoints({cloud, poses}, streetLabels(), max_points);
}

std::map<std::uint32_t, double> shares(const std::vector<QueryPoint>& points) {
  std::map<std::uint32_t, double> result;
  for (const QueryPoint& q : points) result[q.group] += 1.0 / static_cast<double>(points.size());
  return result;
}

TEST(ChoosePoints, AreFewerOfGroundAndMoreOfPosts) {
  const auto points = chosenOf(cloudOf({{kRoad, 9000}, {kWall, 1000}, {kPole, 100}}), 430);
  ASSERT_EQ(points.size(), 430u);
  const auto of = shares(points);
  const auto share = [&](Kind kind) { return of.at(static_cast<std::uint32_t>(kind)); };
  // 9000 / 3, 1000 and 100 * 3
  EXPECT_NEAR(share(Kind::road), 3000 / 4300.0, 0.01);
  EXPECT_NEAR(share(Kind::building), 1000 / 4300.0, 0.01);
  EXPECT_NEAR(share(Kind::pole), 300 / 4300.0, 0.01);
}

TEST(ChoosePoints, KeepTheOrderOfTheCloudAndSpreadOverIt) {
  const auto points = chosenOf(cloudOf({{kRoad, 6000}, {kWall, 2000}}), 400);
  ASSERT_EQ(points.size(), 400u);
  for (std::size_t i = 1; i < points.size(); ++i) EXPECT_LT(points[i - 1].p.x(), points[i].p.x());
  EXPECT_LT(points[0].p.x(), 30);
  EXPECT_GT(points.back().p.x(), 7900);
}

TEST(ChoosePoints, AreAllOfAClassThatHasFewAndNoneOfWhatMoves) {
  const auto points = chosenOf(cloudOf({{kRoad, 100}, {kPole, 5}, {kCar, 50}}), 1000);
  EXPECT_EQ(points.size(), 105u);
  LabelledCloud broken = cloudOf({{kWall, 10}});
  broken.points[3].y = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(chosenOf(broken, 1000).size(), 9u);
  EXPECT_TRUE(chosenOf(cloudOf({{kCar, 20}}), 1000).empty());
}

}  // namespace
}  // namespace xview::pose
