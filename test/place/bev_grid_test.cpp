// SPDX-License-Identifier: BSD-3-Clause
#include "place/bev_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "base/random.h"
#include "bev_scene.h"

namespace xview::test {

namespace {

double groundAt(const BevGrid& view, double x, double y) {
  const GroundCell* cell = knownAt(view, x, y);
  return cell ? view.origin_z + cell->z : std::numeric_limits<double>::quiet_NaN();
}

void expectSameSamples(const BevGrid& a, const BevGrid& b, double tolerance_m) {
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    SCOPED_TRACE(toString(static_cast<BevChannel>(c)));
    ASSERT_EQ(a.samples[c].size(), b.samples[c].size());
    for (const BevSample& s : a.samples[c]) {
      const Eigen::Vector2d p = inFrame(a, s);
      EXPECT_LE(distanceTo(b, static_cast<BevChannel>(c), p.x(), p.y()), tolerance_m);
    }
  }
}

TEST(BevGround, IsNotLiftedByCrownsLabelledAsTerrain) {
  BevScene scene;
  const auto slope = [](double x, double) { return 1 + 0.1 * x; };
  scene.patch(Kind::terrain, 0, 0, 40, 40, slope);
  scene.patch(Kind::terrain, 10, 10, 20, 20, [&](double x, double y) { return slope(x, y) + 5; });
  const BevGrid view = scene.view();
  for (double x = 4.25; x < 36; x += 2)
    EXPECT_NEAR(groundAt(view, x, 15.25), slope(x, 0), 0.12) << x;
  EXPECT_LT(distanceTo(view, BevChannel::obstacle_high, 15.25, 15.25), 0.1)
      << "the crown itself is an obstacle";
  EXPECT_GT(distanceTo(view, BevChannel::obstacle_high, 30.25, 15.25), 9);
}

TEST(BevGround, UnderAWallIsThatOfTheStreetBesideIt) {
  BevScene scene;
  scene.patch(Kind::road, 0, 0, 20, 6, 3.0).wall(Kind::building, 0.2, 9.1, 19.8, 9.1, 3.0, 9.0);
  const BevGrid view = scene.view();
  const GroundCell* foot = knownAt(view, 10.25, 9.25);
  ASSERT_NE(foot, nullptr);
  EXPECT_FALSE(foot->measured);
  EXPECT_NEAR(groundAt(view, 10.25, 9.25), 3.0, 0.1);
  const GroundCell* road = knownAt(view, 10.25, 3.25);
  ASSERT_NE(road, nullptr);
  EXPECT_TRUE(road->measured);
}

TEST(BevGround, FarFromAnyGroundIsAsHighAsUsual) {
  BevScene scene;
  scene.patch(Kind::road, 0, 0, 20, 6, 3.0).wall(Kind::building, 0.2, 49.1, 19.8, 49.1, 3.0, 9.0);
  EXPECT_NEAR(groundAt(scene.view(), 10.25, 49.25), 3.0, 0.1);
}

TEST(BevGround, IsTheLowestOfAllPointsIfNoGroundClassWasSeen) {
  BevScene scene;
  for (double y = 0.25; y < 20; y += 2) scene.wall(Kind::building, 0, y, 20, y, -2.0, 6.0);
  EXPECT_NEAR(groundAt(scene.view(), 10.25, 10.25), -2, 0.5);
}

TEST(BevGround, FromTheAirIsUnbiasedUnderStereoNoise) {
  Random random(3);
  BevScene scene;
  for (int i = 0; i < 40000; ++i) {
    scene.point(Kind::road, random.uniform(0, 40), random.uniform(0, 40), 1.5 * random.normal());
  }
  const BevGrid aerial = scene.view(true), ground = scene.view(false);
  const auto mean = [](const BevGrid& view) {
    double sum = 0;
    for (const GroundCell& cell : view.known) sum += view.origin_z + cell.z;
    return sum / static_cast<double>(view.known.size());
  };
  EXPECT_NEAR(mean(aerial), 0, 0.1);
  EXPECT_LT(std::abs(mean(aerial)), std::abs(mean(ground)));
}

TEST(BevGrid, IsAerialIfHalfOfTheVotesCameFromTheAir) {
  BevScene three, one;
  three.patch(Kind::road, 0, 0, 9, 6, 0.0);
  one.patch(Kind::road, 0, 0, 3, 6, 0.0);
  const auto mixed = [&](bool three_aerial, bool one_aerial) {
    BevGridBuilder builder(bevLabels());
    three.addTo(builder, three_aerial);
    one.addTo(builder, one_aerial);
    return builder.build().aerial;
  };
  EXPECT_FALSE(mixed(false, false));
  EXPECT_FALSE(mixed(false, true));
  EXPECT_TRUE(mixed(true, false));
}

TEST(BevGrid, OfATownIsAerialIfItsBuildingsAreRoofs) {
  const auto roof = [](double, double) { return 6.0; };
  BevScene from_above, below, walls, high_walls;
  from_above.patch(Kind::road, 0, 0, 40, 10, 0.0).patch(Kind::building, 0, 10, 40, 30, roof);
  below.patch(Kind::road, 0, 0, 40, 30, 0.0).patch(Kind::building, 0, 10, 40, 30, roof);
  walls.patch(Kind::road, 0, 0, 40, 10, 0.0).wall(Kind::building, 0, 10.1, 40, 10.1, 0.0, 9.0);
  high_walls.patch(Kind::road, 0, 0, 40, 10, 0.0);
  for (double y = 10.1; y < 30; y += 3) high_walls.wall(Kind::building, 0, y, 40, y, 3.0, 9.0);
  BevScene smeared_walls, cornices;
  smeared_walls.patch(Kind::road, 0, 0, 40, 10, 0.0);
  for (double y = 10.1; y < 20; y += 0.25)
    smeared_walls.wall(Kind::building, 0, y, 40, y, 3.0, 9.0);
  cornices.patch(Kind::road, 0, 0, 40, 10, 0.0);
  for (double y = 10.1; y < 30; y += 3) cornices.patch(Kind::building, 0, y, 40, y + 0.3, roof);
  const auto isAerial = [](const BevScene& scene, bool tells_by_roofs) {
    BevGridBuilder builder(bevLabels());
    scene.addTo(builder, false);
    return builder.build(tells_by_roofs).aerial;
  };
  EXPECT_TRUE(isAerial(from_above, true));
  EXPECT_FALSE(isAerial(from_above, false)) << "rooms have ceilings";
  EXPECT_FALSE(isAerial(below, true)) << "there is a floor under it";
  EXPECT_FALSE(isAerial(walls, true));
  EXPECT_FALSE(isAerial(high_walls, true)) << "of which hedges hide the foot";
  EXPECT_FALSE(isAerial(smeared_walls, true)) << "they fill an area, but are not thin";
  EXPECT_FALSE(isAerial(cornices, true)) << "they are thin, but fill no area";
}

TEST(BevFloor, BorderRunsBetweenRoadAndSidewalkCells) {
  BevScene scene;
  scene.patch(Kind::road, 2, 2, 22, 10, 0.0).patch(Kind::sidewalk, 2, 10, 22, 16, 0.1);
  const BevGrid view = scene.view();
  const auto& border = view[BevChannel::border_road_sidewalk];
  ASSERT_EQ(border.size(), 40u);
  for (std::size_t i = 0; i < border.size(); ++i) {
    EXPECT_FLOAT_EQ(border[i].x, 2.25f + 0.5f * static_cast<float>(i));
    EXPECT_FLOAT_EQ(border[i].y, 10);
  }
  EXPECT_TRUE(view[BevChannel::border_road_terrain].empty());
  EXPECT_TRUE(view[BevChannel::border_sidewalk_terrain].empty());
  EXPECT_EQ(view[BevChannel::road].size(), 40u * 16);
  EXPECT_EQ(view[BevChannel::sidewalk].size(), 40u * 12);
}

TEST(BevFloor, EachPairOfClassesHasItsBorder) {
  BevScene scene;
  scene.patch(Kind::road, 2, 2, 10, 10, 0.0).patch(Kind::sidewalk, 10, 2, 18, 10, 0.0);
  scene.patch(Kind::terrain, 18, 2, 26, 10, 0.0).patch(Kind::road, 26, 2, 34, 10, 0.0);
  const BevGrid view = scene.view();
  EXPECT_NEAR(distanceTo(view, BevChannel::border_road_sidewalk, 10, 6.25), 0, 1e-5);
  EXPECT_NEAR(distanceTo(view, BevChannel::border_sidewalk_terrain, 18, 6.25), 0, 1e-5);
  EXPECT_NEAR(distanceTo(view, BevChannel::border_road_terrain, 26, 6.25), 0, 1e-5);
}

TEST(BevFloor, LaneMarkingsAreRoadWithAChannelOfTheirOwn) {
  BevScene scene;
  scene.patch(Kind::road, 2, 2, 12, 6, 0.0).patch(Kind::lane_marking, 2, 6, 12, 7, 0.0);
  scene.patch(Kind::road, 2, 7, 12, 11, 0.0);
  const BevGrid view = scene.view();
  EXPECT_EQ(view[BevChannel::road].size(), 20u * 18);
  EXPECT_EQ(view[BevChannel::lane_marking].size(), 20u * 2);
}

TEST(BevFloor, SingleCellsOfAnotherClassAreVotedDown) {
  BevScene scene;
  scene.patch(Kind::road, 2, 2, 12, 12, 0.0);
  for (int i = 0; i < 3; ++i) scene.patch(Kind::sidewalk, 6, 6, 6.5, 6.5, 0.0);
  const BevGrid view = scene.view();
  EXPECT_TRUE(view[BevChannel::sidewalk].empty());
  EXPECT_TRUE(view[BevChannel::border_road_sidewalk].empty());
  EXPECT_EQ(view[BevChannel::road].size(), 20u * 20);
}

TEST(BevObstacles, WallStandsWhereItsPointsAre) {
  BevScene scene;
  scene.patch(Kind::road, 0, 0, 20, 8, 0.0).wall(Kind::building, 0, 10.1, 20, 10.1, 0, 6);
  const BevGrid view = scene.view();
  for (const BevChannel c : {BevChannel::building, BevChannel::wall_foot}) {
    ASSERT_EQ(view[c].size(), 40u) << toString(c);
    for (const BevSample& s : view[c]) EXPECT_NEAR(s.y, 10.1, 1e-3);
  }
  EXPECT_EQ(view[BevChannel::obstacle_low].size(), 40u);
  EXPECT_EQ(view[BevChannel::obstacle_high].size(), 40u);
}

TEST(BevObstacles, FacadeSeenOnlyAboveHasNoFoot) {
  BevScene scene;
  scene.patch(Kind::road, 0, 0, 20, 8, 0.0).wall(Kind::building, 0, 10.1, 20, 10.1, 3, 6);
  const BevGrid view = scene.view();
  EXPECT_EQ(view[BevChannel::building].size(), 40u);
  EXPECT_TRUE(view[BevChannel::wall_foot].empty());
}

TEST(BevObstacles, LabelsSpiltOnTheGroundAreLeftOut) {
  BevScene scene;
  scene.patch(Kind::road, 0, 0, 20, 20, 0.0).patch(Kind::fence, 4, 4, 8, 8, 0.15);
  const BevGrid view = scene.view();
  EXPECT_TRUE(view[BevChannel::fence].empty());
  EXPECT_TRUE(view[BevChannel::obstacle_low].empty());
}

TEST(BevObstacles, CrownsAreCanopyAndHedgesLowVegetation) {
  BevScene scene;
  scene.patch(Kind::terrain, 0, 0, 30, 20, 0.0);
  scene.patch(Kind::vegetation, 4, 4, 8, 8, 5.0)
      .wall(Kind::vegetation, 20, 4.2, 20, 16.2, 0.2, 1.7);
  const BevGrid view = scene.view();
  EXPECT_LT(distanceTo(view, BevChannel::canopy, 6, 6), 0.5);
  EXPECT_GT(distanceTo(view, BevChannel::canopy, 20, 10), 9);
  EXPECT_LT(distanceTo(view, BevChannel::low_vegetation, 20, 10), 0.5);
  EXPECT_GT(distanceTo(view, BevChannel::low_vegetation, 6, 6), 9);
}

TEST(BevObjects, CarsAreClustersOfTheirSize) {
  const auto box = [](double length) {
    BevScene scene;
    scene.patch(Kind::road, 0, 0, 40, 20, 0.0);
    for (const double y : {10.0, 11.6}) scene.wall(Kind::vehicle, 10, y, 10 + length, y, 0.3, 1.4);
    scene.patch(Kind::vehicle, 10, 10, 10 + length, 11.6, 1.4);
    return scene.view();
  };
  const BevGrid car = box(4), train = box(16);
  ASSERT_EQ(car[BevChannel::vehicle].size(), 1u);
  EXPECT_LT(distanceTo(car, BevChannel::vehicle, 12, 10.8), 0.2);
  EXPECT_TRUE(train[BevChannel::vehicle].empty());
  EXPECT_FALSE(train[BevChannel::vehicle_surface].empty());
}

TEST(BevObjects, TreesAreMaximaOfTheCanopy) {
  BevScene scene;
  scene.patch(Kind::terrain, 0, 0, 40, 20, 0.0);
  for (const double x : {10.25, 19.25}) {
    for (const double r : {2.5, 1.5, 0.75}) {
      scene.patch(Kind::vegetation, x - r, 10.25 - r, x + r, 10.25 + r, 7 - r);
    }
  }
  const BevGrid view = scene.view();
  ASSERT_EQ(view[BevChannel::tree].size(), 2u);
  EXPECT_LT(distanceTo(view, BevChannel::tree, 10.25, 10.25), 0.5);
  EXPECT_LT(distanceTo(view, BevChannel::tree, 19.25, 10.25), 0.5);
}

TEST(BevObjects, ThinTallVegetationIsATrunk) {
  BevScene scene;
  scene.patch(Kind::terrain, 0, 0, 20, 20, 0.0);
  scene.column(Kind::vegetation, 10.2, 10.2, 0.2, 3.5).column(Kind::trunk, 5.2, 5.2, 0.2, 1.8);
  const BevGrid view = scene.view();
  ASSERT_EQ(view[BevChannel::trunk].size(), 2u);
  EXPECT_LT(distanceTo(view, BevChannel::trunk, 10.2, 10.2), 0.05);
  EXPECT_LT(distanceTo(view, BevChannel::trunk, 5.2, 5.2), 0.05);
}

TEST(BevGrid, OfNothingIsEmpty) {
  const BevGrid view = BevGridBuilder(bevLabels()).build();
  EXPECT_EQ(view.sampleCount(), 0u);
  EXPECT_TRUE(view.known.empty());
  EXPECT_FALSE(view.aerial);
  EXPECT_TRUE(BevScene().view().known.empty());
}

TEST(BevGrid, IgnoresClassesWithoutInformationPointsWithoutVotesAndNoNumbers) {
  BevScene plain, noisy;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  noisy.point(Kind::road, nan, 3, 0).point(Kind::none, 500, 500, 20);
  noisy.point(Kind::pole, 700, 3, 0, 0);
  for (BevScene* scene : {&plain, &noisy}) scene->patch(Kind::road, 2, 2, 12, 12, 0.0);
  noisy.point(Kind::road, 3, std::numeric_limits<float>::infinity(), 0);
  const BevGrid a = plain.view(), b = noisy.view();
  EXPECT_EQ(a.known.size(), b.known.size());
  expectSameSamples(a, b, 0);
}

TEST(BevGrid, OfASinglePointKnowsItsCell) {
  BevScene scene;
  scene.point(Kind::road, 70.1, -3.2, 5);
  const BevGrid view = scene.view();
  ASSERT_EQ(view.known.size(), 1u);
  EXPECT_EQ(view.origin_x, 64);
  EXPECT_EQ(view.origin_y, -64);
  EXPECT_EQ(view.known[0].x, 12);
  EXPECT_EQ(view.known[0].y, 121);
}

TEST(BevGrid, LeavesOutWildPoints) {
  BevScene plain, wild;
  wild.point(Kind::road, 1e30, 0, 0).point(Kind::road, 0, -3e38, 0);
  for (BevScene* scene : {&plain, &wild}) scene->patch(Kind::road, 2, 2, 12, 12, 0.0);
  EXPECT_EQ(plain.view().known.size(), wild.view().known.size());
}

TEST(BevGrid, DoesNotDependOnTheOrderOfThePoints) {
  const BevGrid a = junction().view(), b = junction().reversed().view();
  EXPECT_EQ(a.known.size(), b.known.size());
  expectSameSamples(a, b, 0.002);
}

TEST(BevGrid, CellsAndSamplesAreSortedAndCellsUnique) {
  const BevGrid view = junction().view();
  const auto rowsFirst = [](const auto& a, const auto& b) {
    return a.y != b.y ? a.y < b.y : a.x < b.x;
  };
  for (const auto& channel : view.samples) {
    EXPECT_TRUE(std::is_sorted(channel.begin(), channel.end(), rowsFirst));
  }
  EXPECT_TRUE(std::is_sorted(view.known.begin(), view.known.end(), rowsFirst));
  std::set<std::pair<int, int>> cells;
  for (const GroundCell& c : view.known) EXPECT_TRUE(cells.emplace(c.y, c.x).second);
}

TEST(BevGrid, EverySampleOfASurfaceLiesInASeenCell) {
  const BevGrid view = junction().view();
  for (std::size_t c = 0; c < static_cast<std::size_t>(BevChannel::border_road_sidewalk); ++c) {
    for (const BevSample& s : view.samples[c]) {
      const Eigen::Vector2d p = inFrame(view, s);
      EXPECT_NE(knownAt(view, p.x(), p.y()), nullptr) << toString(static_cast<BevChannel>(c));
    }
  }
}

TEST(BevGrid, FollowsAShiftOfTheFrameByTilesExactly) {
  Eigen::Isometry3d shift = Eigen::Isometry3d::Identity();
  shift.translation() << 640, -128, 64;
  const BevGrid here = junction().view(), there = junction().view(false, shift);
  EXPECT_EQ(there.origin_x, here.origin_x + 640);
  EXPECT_EQ(there.origin_y, here.origin_y - 128);
  EXPECT_EQ(there.origin_z, here.origin_z + 64);
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    ASSERT_EQ(here.samples[c].size(), there.samples[c].size());
    for (std::size_t i = 0; i < here.samples[c].size(); ++i) {
      EXPECT_EQ(here.samples[c][i].x, there.samples[c][i].x);
      EXPECT_EQ(here.samples[c][i].y, there.samples[c][i].y);
    }
  }
}

TEST(BevGrid, FollowsATurnOfTheFrame) {
  Eigen::Isometry3d turn = Eigen::Isometry3d::Identity();
  turn.linear() << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const BevGrid here = junction().view(), there = junction().view(false, turn);
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    const auto channel = static_cast<BevChannel>(c);
    SCOPED_TRACE(toString(channel));
    EXPECT_NEAR(static_cast<double>(here[channel].size()),
                static_cast<double>(there[channel].size()),
                0.02 * static_cast<double>(here[channel].size()));
    for (const BevSample& s : here[channel]) {
      const Eigen::Vector2d p = inFrame(here, s);
      EXPECT_LT(distanceTo(there, channel, -p.y(), p.x()), 0.3);
    }
  }
}

TEST(BevGrid, JunctionFeedsAlmostEveryChannel) {
  const BevGrid view = junction().view();
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    const auto channel = static_cast<BevChannel>(c);
    if (channel == BevChannel::other_surface || channel == BevChannel::low_vegetation) continue;
    EXPECT_FALSE(view[channel].empty()) << toString(channel);
  }
  EXPECT_EQ(view[BevChannel::pole].size(), 3u);
  EXPECT_EQ(view[BevChannel::tree].size(), 2u);
  EXPECT_EQ(view[BevChannel::vehicle].size(), 1u);
}

}  // namespace
}  // namespace xview::test
