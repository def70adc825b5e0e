// SPDX-License-Identifier: BSD-3-Clause
#include "search/heights.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"

namespace xview::search {
namespace {

constexpr double kSlopeX = 0.03, kSlopeY = -0.05, kHeight_m = 2.5;  // map against query
constexpr double kLevel = 0.2;

double roadHeight(double x, double y) { return 0.4 * std::sin(x / 9) + 0.3 * std::cos(y / 7); }

/// A map whose ground was measured within `half_width_m` of the x axis.
DistanceField hillyMap(double half_width_m) {
  BevGrid map;
  for (int cy = -80; cy < 80; ++cy) {
    for (int cx = -120; cx < 120; ++cx) {
      const double x = (cx + 0.5) * map.cell_m, y = (cy + 0.5) * map.cell_m;
      if (std::abs(y) > half_width_m) continue;
      map.known.push_back({cx, cy, static_cast<float>(roadHeight(x, y)), true});
    }
  }
  return DistanceField(map);
}

/// The same ground as a query has it that lies at `pose`, tilted and lowered.
std::vector<SurfaceSamples::Ground> tiltedGround(const PlacePose& pose, double noise_m,
                                                 double wrong_share) {
  Random random(4);
  std::vector<SurfaceSamples::Ground> ground;
  for (int i = 0; i < 600; ++i) {
    const double qx = random.uniform(-25, 25), qy = random.uniform(-25, 25);
    const double x = std::cos(pose.yaw) * qx - std::sin(pose.yaw) * qy,
                 y = std::sin(pose.yaw) * qx + std::cos(pose.yaw) * qy;
    double z = roadHeight(pose.x + x, pose.y + y) - kHeight_m - kSlopeX * x - kSlopeY * y +
               noise_m * random.normal();
    if (random.uniform() < wrong_share) z += random.uniform(1, 6);
    ground.push_back({static_cast<float>(qx), static_cast<float>(qy), static_cast<float>(z)});
  }
  return ground;
}

HeightFit fitted(const DistanceField& field, const std::vector<SurfaceSamples::Ground>& ground,
                 const PlacePose& pose, double slope_sigma) {
  return fitHeights(groundPairs(field, ground, pose), groundHeights(slope_sigma));
}

TEST(GroundHeights, FindsTheSlopeBetweenQueryAndMap) {
  const DistanceField field = hillyMap(40);
  const PlacePose pose{3, -2, 1.1, 0};
  const HeightFit fit = fitted(field, tiltedGround(pose, 0.02, 0), pose, kLevel);
  EXPECT_NEAR(fit.height_m, kHeight_m, 0.02);
  EXPECT_NEAR(fit.slope.x(), kSlopeX, 0.002);
  EXPECT_NEAR(fit.slope.y(), kSlopeY, 0.002);
  EXPECT_GT(fit.cells, 400);
}

TEST(GroundHeights, PassesOverThingsThatAreNoGround) {
  const DistanceField field = hillyMap(40);
  const PlacePose pose{3, -2, 1.1, 0};
  const HeightFit fit = fitted(field, tiltedGround(pose, 0.05, 0.3), pose, kLevel);
  EXPECT_NEAR(fit.height_m, kHeight_m, 0.05);
  EXPECT_NEAR(fit.slope.x(), kSlopeX, 0.004);
  EXPECT_NEAR(fit.slope.y(), kSlopeY, 0.004);
}

TEST(GroundHeights, IsLessSureAcrossANarrowStreetThanAlongIt) {
  const PlacePose pose{3, 0, 0, 0};
  const HeightFit fit = fitted(hillyMap(4), tiltedGround(pose, 0.05, 0), pose, kLevel);
  ASSERT_GT(fit.cells, 0);
  EXPECT_GT(fit.covariance(2, 2), 4 * fit.covariance(1, 1));
}

TEST(GroundHeights, LeavesAQueryLevelThatIsSurelyLevel) {
  const PlacePose pose{3, 0, 0, 0};
  const HeightFit sure = fitted(hillyMap(40), tiltedGround(pose, 0.05, 0), pose, 1e-5);
  EXPECT_NEAR(sure.slope.norm(), 0, 1e-3);
  const HeightFit to_a_quarter_of_a_degree =
      fitted(hillyMap(40), tiltedGround(pose, 0.05, 0), pose, 4e-3);
  EXPECT_NEAR(to_a_quarter_of_a_degree.slope.norm(), 0, 4e-3);
}

TEST(GroundHeights, SaysNothingWithoutCommonGround) {
  const PlacePose far{500, 0, 0, 0};
  EXPECT_EQ(fitted(hillyMap(40), tiltedGround({}, 0.05, 0), far, kLevel).cells, 0);
  EXPECT_EQ(fitted(hillyMap(40), {}, {}, kLevel).cells, 0);
}

/// A flat map at a height of 7 m that was seen, but whose ground was not.
DistanceField mapOfThingsOnly() {
  BevGrid map;
  for (int cy = -80; cy < 80; ++cy) {
    for (int cx = -80; cx < 80; ++cx) map.known.push_back({cx, cy, 7, false});
  }
  return DistanceField(map);
}

SurfaceSamples queryOfThingsOnly() {
  SurfaceSamples query;
  for (int i = 0; i < 20; ++i)
    query.fine.push_back(
        {static_cast<float>(i), 3, static_cast<std::uint8_t>(BevChannel::pole), -4});
  return query;
}

TEST(HeightOffset, ComesFromMeasuredGroundWhereBothKnowIt) {
  SurfaceSamples query = queryOfThingsOnly();
  const PlacePose pose{3, -2, 1.1, 0};
  query.ground = tiltedGround(pose, 0, 0);
  EXPECT_NEAR(heightOffset(hillyMap(40), query, pose), kHeight_m, 0.1);
}

TEST(HeightOffset, ComesFromWhatStandsAroundWhereNoGroundWasMeasured) {
  EXPECT_NEAR(heightOffset(mapOfThingsOnly(), queryOfThingsOnly(), {1, 2, 0.4, 0}), 11, 1e-6);
}

TEST(HeightOffset, IsZeroWhereNothingMeets) {
  EXPECT_EQ(heightOffset(mapOfThingsOnly(), queryOfThingsOnly(), {5000, 0, 0, 0}), 0);
  EXPECT_EQ(heightOffset(mapOfThingsOnly(), {}, {}), 0);
}

std::vector<HeightPair> plane(double offset, double slope_x, double slope_y, int count,
                              double sigma, Random& random) {
  std::vector<HeightPair> pairs;
  for (int i = 0; i < count; ++i) {
    const double x = random.uniform(-40, 40), y = random.uniform(-40, 40);
    pairs.push_back({x, y, offset + slope_x * x + slope_y * y + sigma * random.normal()});
  }
  return pairs;
}

TEST(VertexHeights, FindsAPlaneDespiteOutliers) {
  Random random(1);
  std::vector<HeightPair> pairs = plane(7, 0.02, -0.015, 60, 0.2, random);
  for (int i = 0; i < 12; ++i) pairs[static_cast<std::size_t>(i)].rise += 10;
  const HeightFit fit = fitHeights(pairs, vertexHeights());
  EXPECT_NEAR(fit.height_m, 7, 0.15);
  EXPECT_NEAR(fit.slope.x(), 0.02, 0.004);
  EXPECT_NEAR(fit.slope.y(), -0.015, 0.004);
}

TEST(VertexHeights, FewPairsGiveTheMedianOnly) {
  const HeightFit fit = fitHeights({{0, 0, 1}, {10, 0, 2}, {20, 0, 9}}, vertexHeights());
  EXPECT_EQ(fit.height_m, 2);
  EXPECT_EQ(fit.slope.norm(), 0);
  EXPECT_EQ(fitHeights({}, vertexHeights()).height_m, 0);
}

TEST(VertexHeights, PairsOnALineLeaveTheOtherSlopeAlone) {
  std::vector<HeightPair> pairs;
  for (int i = -20; i <= 20; ++i) pairs.push_back({1.0 * i, 0, 3 + 0.02 * i});
  const HeightFit fit = fitHeights(pairs, vertexHeights());
  EXPECT_NEAR(fit.slope.x(), 0.02, 0.003);
  EXPECT_EQ(fit.slope.y(), 0);
}

double costOf(const std::vector<HeightPair>& pairs) {
  return heightCost(pairs, fitHeights(pairs, vertexHeights()));
}

TEST(VertexHeights, AgreeingHeightsCostNothingAtAnyOffset) {
  Random random(3);
  EXPECT_NEAR(costOf(plane(0, 0, 0, 40, 0, random)), 0, 1e-6);
  EXPECT_NEAR(costOf(plane(250, 0, 0, 40, 0, random)), 0, 1e-6);
  EXPECT_EQ(costOf({}), 0);
}

TEST(VertexHeights, PairsOfUnsteadyHeightsTellLess) {
  Random random(6);
  std::vector<HeightPair> pairs = plane(3, 0, 0, 40, 2, random);
  const double cost = costOf(pairs);
  for (HeightPair& p : pairs) p.sigma = 4;
  EXPECT_LT(costOf(pairs), 0.3 * cost);
  // A steady pair outweighs many of them.
  std::vector<HeightPair> mixed = plane(0, 0, 0, 20, 0.1, random);
  for (const HeightPair& p : plane(3, 0, 0, 20, 0.1, random)) {
    mixed.push_back(p);
    mixed.back().sigma = 4;
  }
  EXPECT_NEAR(fitHeights(mixed, vertexHeights()).height_m, 0, 0.2);
}

TEST(VertexHeights, ASteeperHillAndMoreHeightsOffItCostMore) {
  double before = 0;
  for (const double slope : {0.01, 0.03, 0.06, 0.1}) {
    Random random(4);
    const double cost = costOf(plane(0, slope, 0, 40, 0, random));
    EXPECT_GT(cost, before + 0.1) << slope;
    before = cost;
  }
  before = 0;
  for (const int off : {4, 8, 12}) {
    Random random(5);
    std::vector<HeightPair> pairs = plane(0, 0, 0, 60, 0.2, random);
    for (int i = 0; i < off; ++i) pairs[static_cast<std::size_t>(i)].rise += 2;
    const double cost = costOf(pairs);
    EXPECT_GT(cost, before + 2) << off;
    before = cost;
  }
}

TEST(VertexHeights, AWeightlessPairCostsNothing) {
  Random random(6);
  std::vector<HeightPair> pairs = plane(0, 0, 0, 40, 0, random);
  pairs[0].rise = 30;
  const HeightFit flat;
  const double cost = heightCost(pairs, flat);
  pairs[0].weight = 0;
  EXPECT_GT(cost, heightCost(pairs, flat) + 1);
}

}  // namespace
}  // namespace xview::search
