// SPDX-License-Identifier: BSD-3-Clause
#include "pose/free_space_violation.h"

#include <gtest/gtest.h>

#include "support/label_sets.h"

namespace xview::pose {
namespace {

constexpr std::uint32_t kWall = 1, kCupboard = 2, kFloor = 3;
constexpr float kSide_m = 12;

LabelSet roomLabels() {
  return test::labelSetOf("room", {{kWall, "wall", Role::surface, Kind::building},
                                   {kCupboard, "cupboard", Role::object, Kind::other_object},
                                   {kFloor, "floor", Role::surface, Kind::terrain}});
}

/// Points every 10 cm on the square from a corner along two edges.
void addSquare(const Eigen::Vector3f& corner, const Eigen::Vector3f& u, const Eigen::Vector3f& v,
               std::uint32_t label, LabelledCloud& cloud) {
  constexpr float kStep_m = 0.1f;
  for (float a = 0; a < u.norm(); a += kStep_m) {
    for (float b = 0; b < v.norm(); b += kStep_m) {
      const Eigen::Vector3f p = corner + a * u.normalized() + b * v.normalized();
      cloud.points.push_back({p.x(), p.y(), p.z(), label});
      cloud.points.points.back().view = 0;
    }
  }
}

/// Seen from its middle.
LabelledCloud room() {
  LabelledCloud cloud;
  const Eigen::Vector3f x(kSide_m, 0, 0), y(0, kSide_m, 0), z(0, 0, 3), o = Eigen::Vector3f::Zero();
  addSquare(o, x, y, kFloor, cloud);
  addSquare(o, x, z, kWall, cloud);
  addSquare(o, y, z, kWall, cloud);
  addSquare(x, y, z, kWall, cloud);
  addSquare(y, x, z, kWall, cloud);
  return cloud;
}

std::vector<Eigen::Isometry3d> fromItsMiddle() {
  return {Eigen::Isometry3d(Eigen::Translation3d(kSide_m / 2, kSide_m / 2, 1.5))};
}

std::optional<double> freeSpaceViolationIn(LabelledCloud map, const LabelledCloud& query) {
  const DistributionMap distributions(std::move(map), roomLabels(), fromItsMiddle(), {});
  return freeSpaceViolation(distributions, {query, fromItsMiddle()}, roomLabels(),
                            Eigen::Isometry3d::Identity());
}

TEST(FreeSpaceViolation, IsNextToNothingAtTheTruePose) {
  const auto share = freeSpaceViolationIn(room(), room());
  ASSERT_TRUE(share);
  EXPECT_LT(*share, 0.1);
}

TEST(FreeSpaceViolation, GrowsWithWhatIsNotThere) {
  LabelledCloud furnished = room();
  addSquare({3, 1, 0}, {6, 0, 0}, {0, 0, 2}, kCupboard, furnished);
  addSquare({3, 10, 0}, {6, 0, 0}, {0, 0, 2}, kCupboard, furnished);
  const auto share = freeSpaceViolationIn(furnished, room());
  ASSERT_TRUE(share);
  EXPECT_GT(*share, 3 * *freeSpaceViolationIn(room(), room()));
}

TEST(FreeSpaceViolation, WhatHidesBehindThingsOfTheQueryIsNotAsked) {
  LabelledCloud furnished = room(), screened = room();
  addSquare({3, 1, 0}, {6, 0, 0}, {0, 0, 2}, kCupboard, furnished);
  addSquare({2, 2.5, 0}, {8, 0, 0}, {0, 0, 3}, kCupboard, screened);
  // Only what stands before the screen is left of the rays.
  LabelledCloud query;
  for (const Point& p : screened.points) {
    if (p.y >= 2.5f) query.points.push_back(p);
  }
  EXPECT_LT(*freeSpaceViolationIn(furnished, query), 0.1);
}

/// Moved aside it would be seen through as little.
TEST(FreeSpaceViolation, OfARoofFromAboveItTellsNothing) {
  LabelledCloud roof;
  addSquare({0, 0, 0}, {kSide_m, 0, 0}, {0, kSide_m, 0}, kCupboard, roof);
  EXPECT_FALSE(freeSpaceViolationIn(roof, roof));
}

TEST(FreeSpaceViolation, IsNotKnownWithoutRaysOrAMap) {
  LabelledCloud unseen = room();
  for (Point& p : unseen.points) p.view = kNoView;
  EXPECT_FALSE(freeSpaceViolationIn(room(), unseen));
  LabelledCloud far = room();
  far.origin.x() = 500;
  EXPECT_FALSE(freeSpaceViolationIn(far, room()));
  EXPECT_FALSE(freeSpaceViolationIn(room(), {}));
}

}  // namespace
}  // namespace xview::pose
