// SPDX-License-Identifier: BSD-3-Clause
#include "../../src/match/wide_query.h"

#include <gtest/gtest.h>

#include <cmath>

#include "plan_town.h"
#include "xview/types/pose.h"

namespace xview::test {
namespace {

/// Two long streets that cross a third one.
PlanTown longTown(std::uint64_t seed) {
  Random random(seed);
  PlanTown town;
  town.street(-450, 450, 0, random);
  town.street(-300, 450, 70, random);
  town.street(-450, 200, -80, random);
  return town;
}

std::vector<PlanQuery::Sample> randomSamples(int count, double radius_m, Random& random) {
  std::vector<PlanQuery::Sample> samples;
  for (int i = 0; i < count; ++i) {
    samples.push_back({static_cast<float>(random.uniform(-radius_m, radius_m)),
                       static_cast<float>(random.uniform(-radius_m, radius_m)),
                       static_cast<std::uint8_t>(random.below(kChannels))});
  }
  return samples;
}

TEST(WideQuery, IsFoundToTheFractionOfADegreeThatItsRimNeeds) {
  const PlanTown town = longTown(3);
  const PlanView map = town.view({0, 0}, 600, Eigen::Isometry3d::Identity());
  const PlanPlaces places(map, {}, defaultLikelihoods(), {}, 1);
  const Eigen::Isometry3d T_town_query = poseFromYaw({700, -300, 5}, 2.1);
  const PlanQuery query = makePlanQuery(town.view({30, 10}, 400, T_town_query.inverse()));
  ASSERT_GT(radiusOf(query.fine), kWidest_m);
  const auto found = places.search(query, {}, 1);
  ASSERT_FALSE(found.empty());
  const Eigen::Isometry3d T = poseFromYaw({found[0].pose.x, found[0].pose.y, 0}, found[0].pose.yaw);
  for (const Eigen::Vector2d& rim : {Eigen::Vector2d(-350, 0), Eigen::Vector2d(400, 70)}) {
    const Eigen::Vector3d in_query = T_town_query.inverse() * Eigen::Vector3d(rim.x(), rim.y(), 0);
    EXPECT_LT(((T * in_query).head<2>() - rim).norm(), 0.5);
  }
  EXPECT_NEAR(found[0].pose.score, places.score(query, found[0].pose), 1e-6 * found[0].pose.score);
  EXPECT_GT(found[0].known_share, 0.99);
  if (found.size() > 1) {
    EXPECT_GT(found[0].pose.score, 2 * found[1].pose.score);
  }
}

TEST(WideQuery, OfAnotherTownFitsLittle) {
  const PlanView map = longTown(3).view({0, 0}, 600, Eigen::Isometry3d::Identity());
  const PlanPlaces places(map, {}, defaultLikelihoods(), {}, 1);
  const PlanQuery query =
      makePlanQuery(longTown(4).view({0, 0}, 400, Eigen::Isometry3d::Identity()));
  for (const PlanHypothesis& h : places.search(query, {}, 1)) {
    EXPECT_LT(h.pose.score, 0.5 * h.expected);
  }
}

TEST(WideQuery, PriorOfItsCentreHolds) {
  const PlanTown town = longTown(3);
  const PlanPlaces places(town.view({0, 0}, 600, Eigen::Isometry3d::Identity()), {},
                          defaultLikelihoods(), {}, 1);
  const PlanQuery query = makePlanQuery(town.view({0, 0}, 400, Eigen::Isometry3d::Identity()));
  PlacePrior prior;
  prior.near = PlacePrior::Circle{query.centre.x(), query.centre.y(), 5};
  const auto found = places.search(query, prior, 1);
  ASSERT_FALSE(found.empty());
  EXPECT_LT(std::hypot(found[0].pose.x, found[0].pose.y), 0.5);
}

TEST(WideQuery, PartsAreThoseWithinTheirRadius) {
  Random random(1);
  const auto samples = randomSamples(300, 100, random);
  const Eigen::Vector2d centre(20, -30);
  const QueryPart part = partAround(samples, centre, 40);
  std::size_t next = 0;
  for (const PlanQuery::Sample& s : samples) {
    if (std::hypot(s.x - centre.x(), s.y - centre.y()) > 40) continue;
    ASSERT_LT(next, part.samples.size());
    EXPECT_NEAR(part.samples[next].x + 20, s.x, 1e-4);
    EXPECT_NEAR(part.samples[next].y - 30, s.y, 1e-4);
    EXPECT_EQ(part.samples[next++].channel, s.channel);
  }
  EXPECT_EQ(next, part.samples.size());
}

TEST(WideQuery, DensestPartIsWhereMostSamplesAre) {
  Random random(2);
  auto samples = randomSamples(200, 1000, random);
  for (PlanQuery::Sample s : randomSamples(400, 50, random)) {
    s.x += 600;
    s.y -= 200;
    samples.push_back(s);
  }
  const QueryPart part = densestPart(samples, 150);
  EXPECT_GE(part.samples.size(), 400u);
  EXPECT_LT((part.offset - Eigen::Vector2d(600, -200)).norm(), 80);
  EXPECT_TRUE(densestPart({}, 150).samples.empty());
}

TEST(WideQuery, PriorOfAPartIsNeverNarrower) {
  QueryPart part;
  part.offset = {30, 40};
  PlacePrior prior;
  EXPECT_FALSE(priorOfPart(prior, part).near);
  prior.near = PlacePrior::Circle{1, 2, 10};
  EXPECT_DOUBLE_EQ(priorOfPart(prior, part).near->radius, 60);
}

}  // namespace
}  // namespace xview::test
