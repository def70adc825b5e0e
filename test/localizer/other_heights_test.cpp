// SPDX-License-Identifier: BSD-3-Clause
#include "localizer/other_heights.h"

#include <gtest/gtest.h>

#include "map/contents.h"

namespace xview {
namespace {

constexpr double kVoxelStep_m = 0.2, kFloorToFloor_m = 3.2;

void addPoint(double x, double y, double z, LabelledCloud& cloud) {
  cloud.points.emplace_back(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z), 1);
}

/// A floor of 10 x 8 m with four walls and a cupboard.
void addFloor(double bottom, LabelledCloud& cloud) {
  for (double x = 0; x < 10; x += kVoxelStep_m) {
    for (double y = 0; y < 8; y += kVoxelStep_m) addPoint(x, y, bottom, cloud);
    for (double z = kVoxelStep_m; z < 2.4; z += kVoxelStep_m) {
      addPoint(x, 0, bottom + z, cloud);
      addPoint(x, 8, bottom + z, cloud);
      if (x < 8) addPoint(0, x, bottom + z, cloud);
      if (x < 8) addPoint(10, x, bottom + z, cloud);
      if (x > 4 && x < 6) addPoint(x, 3, bottom + z, cloud);
    }
  }
}

struct Meeting {
  Query query;
  map::SemanticMap map;
};

Meeting meetingOfFloors(int floors) {
  Meeting made;
  made.query.poses = {Eigen::Isometry3d::Identity()};
  addFloor(0, made.query.cloud);
  for (int i = 0; i < floors; ++i) addFloor(kFloorToFloor_m * i, made.map.cloud);
  return made;
}

const Eigen::Isometry3d kSecondFloor{Eigen::Translation3d(0, 0, kFloorToFloor_m)};

TEST(OtherHeight, IsThatOfAnEqualFloor) {
  const Meeting two = meetingOfFloors(2);
  const OtherHeight above = bestOtherHeight(two.query, two.map, Eigen::Isometry3d::Identity());
  EXPECT_NEAR(above.above, kFloorToFloor_m, 0.4);
  EXPECT_GT(above.fit, 0.8);
  const OtherHeight below = bestOtherHeight(two.query, two.map, kSecondFloor);
  EXPECT_NEAR(below.above, -kFloorToFloor_m, 0.4);
  EXPECT_GT(below.fit, 0.8);
}

/// Check fix for: points of a map file were looked at beside where they are.
TEST(OtherHeight, IsThatOfPackedPointsFarFromTheOrigin) {
  Meeting two = meetingOfFloors(2);
  const Eigen::Vector3d origin(4e5, 5e6, 300);
  two.map.cloud.origin = origin;
  map::packPoints(two.map);
  ASSERT_TRUE(two.map.cloud.empty());
  const Eigen::Isometry3d T(Eigen::Translation3d{origin});
  const OtherHeight above = bestOtherHeight(two.query, two.map, T);
  EXPECT_NEAR(above.above, kFloorToFloor_m, 0.4);
  EXPECT_GT(above.fit, 0.8);
}

TEST(OtherHeight, OfAnotherFloorFitsLess) {
  Meeting two = meetingOfFloors(1);
  for (double x = 0; x < 10; x += kVoxelStep_m) {  // a hall above it
    for (double y = 0; y < 8; y += kVoxelStep_m) addPoint(x, y, kFloorToFloor_m, two.map.cloud);
  }
  EXPECT_LT(bestOtherHeight(two.query, two.map, Eigen::Isometry3d::Identity()).fit, 0.2);
}

TEST(OtherHeight, OfAStreetHasNoGround) {
  Meeting street = meetingOfFloors(1);
  for (double x = 0; x < 10; x += kVoxelStep_m) {  // its facades are higher than what the query saw
    for (double z = 2.4; z < 12; z += kVoxelStep_m) {
      addPoint(x, 0, z, street.map.cloud);
      addPoint(x, 8, z, street.map.cloud);
    }
  }
  EXPECT_LT(bestOtherHeight(street.query, street.map, Eigen::Isometry3d::Identity()).fit, 0.2);
}

TEST(OtherHeight, OfNothingIsNone) {
  Meeting two = meetingOfFloors(2);
  two.query.cloud.points.clear();
  EXPECT_EQ(bestOtherHeight(two.query, two.map, Eigen::Isometry3d::Identity()).fit, 0);
  two = meetingOfFloors(2);
  two.map.cloud.points.clear();
  EXPECT_EQ(bestOtherHeight(two.query, two.map, Eigen::Isometry3d::Identity()).fit, 0);
}

}  // namespace
}  // namespace xview
