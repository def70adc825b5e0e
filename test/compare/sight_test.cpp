// SPDX-License-Identifier: BSD-3-Clause
#include "compare/sight.h"

#include <gtest/gtest.h>

namespace xview {
namespace {

using Ray = Sight::Ray;

/// A wall at x = 10 as far as y = 0, a farther one at x = 20; seen from the origin.
Place twoWalls() {
  Place place;
  place.poses.push_back(Eigen::Isometry3d::Identity());
  for (float z = -2; z <= 2; z += 0.1f) {
    for (float y = -12; y <= 0; y += 0.1f) place.cloud.points.emplace_back(10.f, y, z);
    for (float y = -24; y <= 24; y += 0.1f) place.cloud.points.emplace_back(20.f, y, z);
  }
  return place;
}

Eigen::AlignedBox3d everywhere() {
  return {Eigen::Vector3d::Constant(-1000), Eigen::Vector3d::Constant(1000)};
}

TEST(Sight, PassesBesideAWallAndNotThroughIt) {
  const Sight sight(twoWalls(), everywhere());
  EXPECT_EQ(sight.to({15, 5, 0}, 0.4), Ray::passes);
  EXPECT_EQ(sight.to({15, -5, 0}, 0.4), Ray::blocked);
  EXPECT_EQ(sight.to({5, -3, 0}, 0.4), Ray::passes);
}

/// Check fix for: rays passed between the points of what was near, so that a pole behind a parked
/// car was told as gone.
TEST(Sight, DoesNotPassBetweenPointsOfASurfaceNearby) {
  Place place = twoWalls();
  for (float z = -1; z <= 1; z += 0.25f) {
    for (float y = 0.5f; y <= 2.5f; y += 0.25f) place.cloud.points.emplace_back(1.5f, y, z);
  }
  const Sight sight(place, everywhere());
  for (double y = 5; y <= 9; y += 0.3) EXPECT_EQ(sight.to({7, y, 0.1}, 0.4), Ray::blocked) << y;
  EXPECT_EQ(sight.to({7, -0.7, 0.1}, 0.4), Ray::passes);
}

/// All directions are around what is straight above.
TEST(Sight, AboveAPoseIsBlockedByWhatIsJustThere) {
  Place place;
  place.poses.push_back(Eigen::Isometry3d::Identity());
  place.cloud.points.emplace_back(0.01f, 0.f, 1.f);
  for (float x = -0.5f; x <= 0.5f; x += 0.02f) {
    for (float y = -0.5f; y <= 0.5f; y += 0.02f) place.cloud.points.emplace_back(x, y, 9.f);
  }
  const Sight sight(place, everywhere());
  EXPECT_EQ(sight.to({-0.05, 0.05, 5}, 0.4), Ray::blocked);
  EXPECT_EQ(sight.to({0.05, 0.5, 5}, 0.4), Ray::blocked) << "also where nothing is behind";
}

TEST(Sight, IsBlockedBehindTheLastThingSeen) {
  const Sight sight(twoWalls(), everywhere());
  EXPECT_EQ(sight.to({25, 8, 0}, 0.4), Ray::blocked);
  EXPECT_EQ(sight.to({20.2, 8, 0}, 0.4), Ray::blocked) << "within the margin of it";
}

TEST(Sight, IsOpenWhereNothingIsKnown) {
  const Sight sight(twoWalls(), everywhere());
  EXPECT_EQ(sight.to({-5, 0, 0}, 0.4), Ray::open);
  EXPECT_EQ(sight.to({2, 0.3, 9}, 0.4), Ray::open);
  EXPECT_EQ(sight.to({-500, 0, 0}, 0.4), Ray::open) << "too far";
}

TEST(Sight, AsksOnlyThePosesNear) {
  const Eigen::AlignedBox3d elsewhere(Eigen::Vector3d(100, 0, 0), Eigen::Vector3d(200, 1, 1));
  EXPECT_EQ(Sight(twoWalls(), elsewhere).to({15, 5, 0}, 0.4), Ray::open);
}

TEST(Sight, PassesIfItDoesFromOneOfManyPoses) {
  Place place = twoWalls();
  place.poses.push_back(Eigen::Isometry3d(Eigen::Translation3d(15, 10, 0)));
  for (float z = -2; z <= 2; z += 0.1f) {
    for (float x = 12; x <= 18; x += 0.1f) place.cloud.points.emplace_back(x, -15.f, z);
  }
  EXPECT_EQ(Sight(twoWalls(), everywhere()).to({15, -5, 0}, 0.4), Ray::blocked);
  EXPECT_EQ(Sight(place, everywhere()).to({15, -5, 0}, 0.4), Ray::passes);
}

}  // namespace
}  // namespace xview
