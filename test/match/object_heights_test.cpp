// SPDX-License-Identifier: BSD-3-Clause
#include "../../src/match/object_heights.h"

#include <gtest/gtest.h>

#include "xview/types/random.h"

namespace xview {
namespace {

std::vector<HeightPair> plane(double offset, double slope_x, double slope_y, int count,
                              double sigma, Random& random) {
  std::vector<HeightPair> pairs;
  for (int i = 0; i < count; ++i) {
    const double x = random.uniform(-40, 40), y = random.uniform(-40, 40);
    pairs.push_back({x, y, offset + slope_x * x + slope_y * y + sigma * random.normal()});
  }
  return pairs;
}

TEST(ObjectHeights, FindsAPlaneDespiteOutliers) {
  Random random(1);
  std::vector<HeightPair> pairs = plane(7, 0.02, -0.015, 60, 0.2, random);
  for (int i = 0; i < 12; ++i) pairs[static_cast<std::size_t>(i)].rise += 10;
  const HeightFit fit = fitHeights(pairs, true);
  EXPECT_NEAR(fit.offset, 7, 0.15);
  EXPECT_NEAR(fit.slope.x(), 0.02, 0.004);
  EXPECT_NEAR(fit.slope.y(), -0.015, 0.004);
}

TEST(ObjectHeights, FewPairsGiveTheMedianOnly) {
  const HeightFit fit = fitHeights({{0, 0, 1}, {10, 0, 2}, {20, 0, 9}}, true);
  EXPECT_EQ(fit.offset, 2);
  EXPECT_EQ(fit.slope.norm(), 0);
  EXPECT_EQ(fitHeights({}, true).offset, 0);
}

TEST(ObjectHeights, NoTiltIfItMayNot) {
  Random random(2);
  EXPECT_EQ(fitHeights(plane(1, 0.05, 0, 50, 0, random), false).slope.norm(), 0);
}

TEST(ObjectHeights, PairsOnALineLeaveTheOtherSlopeAlone) {
  std::vector<HeightPair> pairs;
  for (int i = -20; i <= 20; ++i) pairs.push_back({1.0 * i, 0, 3 + 0.02 * i});
  const HeightFit fit = fitHeights(pairs, true);
  EXPECT_NEAR(fit.slope.x(), 0.02, 0.003);
  EXPECT_EQ(fit.slope.y(), 0);
}

double costOf(const std::vector<HeightPair>& pairs) {
  return heightCost(pairs, fitHeights(pairs, true));
}

TEST(ObjectHeights, AgreeingHeightsCostNothingAtAnyOffset) {
  Random random(3);
  EXPECT_NEAR(costOf(plane(0, 0, 0, 40, 0, random)), 0, 1e-6);
  EXPECT_NEAR(costOf(plane(250, 0, 0, 40, 0, random)), 0, 1e-6);
  EXPECT_EQ(costOf({}), 0);
}

TEST(ObjectHeights, PairsOfUnsteadyHeightsTellLess) {
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
  EXPECT_NEAR(fitHeights(mixed, true).offset, 0, 0.2);
}

TEST(ObjectHeights, ASteeperHillAndMoreHeightsOffItCostMore) {
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

TEST(ObjectHeights, AWeightlessPairCostsNothing) {
  Random random(6);
  std::vector<HeightPair> pairs = plane(0, 0, 0, 40, 0, random);
  pairs[0].rise = 30;
  const HeightFit flat;
  const double cost = heightCost(pairs, flat);
  pairs[0].weight = 0;
  EXPECT_GT(cost, heightCost(pairs, flat) + 1);
}

}  // namespace
}  // namespace xview
