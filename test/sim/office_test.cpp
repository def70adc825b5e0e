// SPDX-License-Identifier: BSD-3-Clause
#include "sim/office.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "base/pose.h"

namespace xview {
namespace {

OfficeOptions seeded(std::uint64_t seed, double alike = 0) {
  OfficeOptions options;
  options.seed = seed;
  options.alike = alike;
  return options;
}

double smallestDepth(const Renderer& renderer, const Eigen::Isometry3d& T_world_body) {
  LidarModel around;
  around.rings = 1;
  around.azimuths = 32;
  around.lowest_deg = around.highest_deg = 0;
  const Frame scan = renderer.renderLidar(around, T_world_body, 1);
  double smallest = around.max_range_m;
  for (std::size_t i = 0; i < scan.cloud.size(); ++i)
    smallest = std::min(smallest, scan.cloud.position(i).norm());
  return smallest;
}

TEST(Office, SameSeedSameFloorAnotherSeedAnother) {
  const Office a = makeOffice(seeded(1)), b = makeOffice(seeded(1)), c = makeOffice(seeded(2));
  EXPECT_EQ(a.mesh.vertices, b.mesh.vertices);
  EXPECT_NE(a.mesh.vertices.size(), c.mesh.vertices.size());
  EXPECT_EQ(a.doors.size(), 40u);  // 2 x 2 blocks of 2 x 5 rooms
}

TEST(Office, WalkKeepsAwayFromWallsAndFurniture) {
  for (const std::uint64_t seed : {3u, 4u, 5u}) {
    const Office office = makeOffice(seeded(seed));
    const Renderer renderer({std::make_shared<RayScene>(office.mesh)});
    for (Eigen::Isometry3d& T : planWalk(office, 80, 0.4, false, seed)) {
      T.translation().z() = 1.15;
      EXPECT_GT(smallestDepth(renderer, T), 0.2) << T.translation().transpose();
    }
  }
}

TEST(Office, WalkIsOfItsLengthAndMovesALittleAtATime) {
  const Office office = makeOffice(seeded(3));
  const auto walk = planWalk(office, 60, 0.4, false, 7);
  double length = 0;
  for (std::size_t i = 1; i < walk.size(); ++i) {
    const double step = (walk[i].translation() - walk[i - 1].translation()).norm();
    EXPECT_LT(step, 0.61);
    EXPECT_LT(rotationBetween(walk[i], walk[i - 1]), 16 * M_PI / 180);
    length += step;
  }
  EXPECT_NEAR(length, 60, 6);
  const auto back = planWalk(office, 60, 0.4, true, 7);
  EXPECT_LT((back.front().translation() - walk.back().translation()).norm(), 1e-9);
}

TEST(Office, RoomsThatFollowThePatternAreFurnishedAlike) {
  const Office office = makeOffice(seeded(1, 1));
  // All rooms with the door on the same side have the same desks: seats come in two patterns.
  std::set<std::pair<long, long>> shapes;
  for (const Seat& seat : office.seats) {
    const OfficeOptions& o = office.options;
    const double x = std::fmod(seat.position.x(), o.rooms * o.room_width_m + o.corridor_m);
    shapes.insert({std::lround(100 * std::fmod(x, o.room_width_m)),
                   std::lround(100 * std::abs(std::cos(seat.yaw)))});
  }
  EXPECT_LE(shapes.size(), 16u);
  EXPECT_GT(office.seats.size(), 2 * shapes.size());
}

TEST(Office, ClutterMovesFromDayToDay) {
  const Office office = makeOffice(seeded(1));
  EXPECT_EQ(makeClutter(office, 5).vertices, makeClutter(office, 5).vertices);
  EXPECT_NE(makeClutter(office, 5).vertices, makeClutter(office, 6).vertices);
}

}  // namespace
}  // namespace xview
