// SPDX-License-Identifier: BSD-3-Clause
#include "xview/match/plan_places.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "plan_town.h"
#include "xview/types/pose.h"

namespace xview::test {
namespace {

constexpr double kDegree = M_PI / 180;

PlanView wholeTown(const PlanTown& town) {
  return town.view(Eigen::Vector2d::Zero(), 150, Eigen::Isometry3d::Identity());
}

PlanPlaces indexOf(const PlanTown& town, const PlaceOptions& options = {}) {
  return PlanPlaces(wholeTown(town), driveThrough(), defaultLikelihoods(), options, 1);
}

/// A query of `radius` about a place of the town in a frame of its own.
struct MovedQuery {
  MovedQuery(const PlanTown& town, const Eigen::Vector2d& place, double radius_m,
             const Eigen::Isometry3d& T_town_query)
      : truth(T_town_query),
        query(makePlanQuery(town.view(place, radius_m, T_town_query.inverse()))) {}
  Eigen::Isometry3d truth;  ///< query frame to town
  PlanQuery query;
};

/// Error of a hypothesis at the query centre [m] and in heading [deg].
struct PoseError {
  double metres, degrees;
};
PoseError errorOf(const PlanHypothesis& h, const MovedQuery& moved) {
  const Eigen::Vector3d centre(moved.query.centre.x(), moved.query.centre.y(), 0);
  const Eigen::Isometry3d found = poseFromYaw({h.pose.x, h.pose.y, 0}, h.pose.yaw);
  return {((found * centre) - (moved.truth * centre)).head<2>().norm(),
          std::abs(angleDifference(h.pose.yaw, yawOf(moved.truth.linear()))) / kDegree};
}

TEST(PlanPlaces, FindsAPlaceAgainAfterAnyMotionOfTheQuery) {
  const PlanTown town = randomTown(5);
  const PlanPlaces places = indexOf(town);
  Random random(9);
  for (int i = 0; i < 6; ++i) {
    const Eigen::Vector2d place(random.uniform(-80, 80),
                                45.0 * (static_cast<int>(random.below(3)) - 1));
    const Eigen::Isometry3d T =
        poseFromYaw({random.uniform(-500, 500), random.uniform(-500, 500), random.uniform(-20, 20)},
                    random.uniform(-M_PI, M_PI));
    const MovedQuery moved(town, place, 30, T);
    const auto found = places.search(moved.query, {}, 1);
    ASSERT_FALSE(found.empty());
    const PoseError error = errorOf(found[0], moved);
    EXPECT_LT(error.metres, 0.25) << "query " << i;
    EXPECT_LT(error.degrees, 0.5) << "query " << i;
    EXPECT_NEAR(found[0].z, T.translation().z(), 0.05) << "query " << i;
    EXPECT_GT(found[0].known_share, 0.99);
    EXPECT_GT(found[0].pose.score, 0.7 * found[0].expected);
    if (found.size() > 1) {
      EXPECT_GT(found[0].pose.score, found[1].pose.score + 60);
    }
  }
}

TEST(PlanPlaces, FindsAPlaceInAMapFarFromItsOrigin) {
  const PlanTown town = randomTown(5);
  // Map frame = town frame + (4e6, -5e5): plan origins carry the large part.
  const Eigen::Isometry3d T_map_town = poseFromYaw({4e6, -5e5, 100}, 0);
  PlanView map = town.view(Eigen::Vector2d::Zero(), 150, T_map_town, 4e6, -5e5);
  map.origin_z = 64;
  for (GroundCell& cell : map.known) cell.z -= 64;
  const PlanPlaces places(map, {}, defaultLikelihoods(), {}, 1);
  const MovedQuery moved(town, {20, 45}, 30, poseFromYaw({3, -8, 2}, 0.7));
  const auto found = places.search(moved.query, {}, 1);
  ASSERT_FALSE(found.empty());
  const Eigen::Isometry3d expected = T_map_town * moved.truth;
  EXPECT_NEAR(found[0].pose.x, expected.translation().x(), 0.25);
  EXPECT_NEAR(found[0].pose.y, expected.translation().y(), 0.25);
  EXPECT_NEAR(found[0].z, expected.translation().z(), 0.05);
}

TEST(PlanPlaces, KnowsTheHeightOfAQueryWithoutGround) {
  const PlanTown town = randomTown(5);
  PlanView map = wholeTown(town);
  map.origin_z = 64;
  for (GroundCell& cell : map.known) cell.z -= 64;
  const MovedQuery moved(town, {20, 45}, 30, poseFromYaw({3, -8, 250}, 0.7));
  PlanView view = town.view({20, 45}, 30, moved.truth.inverse());
  for (const Channel c : {Channel::road, Channel::sidewalk, Channel::terrain}) view[c].clear();
  const auto found =
      PlanPlaces(map, {}, defaultLikelihoods(), {}, 1).search(makePlanQuery(view), {}, 1);
  ASSERT_FALSE(found.empty());
  EXPECT_LT(errorOf(found[0], moved).metres, 0.5);
  EXPECT_NEAR(found[0].z, moved.truth.translation().z(), 1);
}

TEST(PlanPlaces, SearchGivesTheSameBytesForAnyNumberOfThreads) {
  const PlanTown town = randomTown(6);
  const PlanView map = wholeTown(town);
  const MovedQuery moved(town, {-40, 0}, 30, poseFromYaw({70, -20, 0}, 2.1));
  const auto run = [&](int threads) {
    return PlanPlaces(map, driveThrough(), defaultLikelihoods(), {}, threads)
        .search(moved.query, {}, threads);
  };
  const auto one = run(1), two = run(2);
  ASSERT_EQ(one.size(), two.size());
  ASSERT_FALSE(one.empty());
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(std::memcmp(&one[i].pose, &two[i].pose, sizeof(PlacePose)), 0) << i;
    EXPECT_EQ(one[i].z, two[i].z);
    EXPECT_EQ(one[i].expected, two[i].expected);
  }
}

TEST(PlanPlaces, BestFirstAndDistinct) {
  const PlanTown town = randomTown(6);
  PlaceOptions options;
  options.refine_poses = 8;
  const PlanPlaces places = indexOf(town, options);
  const MovedQuery moved(town, {-40, 0}, 30, poseFromYaw({70, -20, 0}, 2.1));
  const auto found = places.search(moved.query, {}, 1);
  ASSERT_GT(found.size(), 1u);
  EXPECT_LE(found.size(), 8u);
  const Eigen::Vector3d centre(moved.query.centre.x(), moved.query.centre.y(), 0);
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (i > 0) {
      EXPECT_LE(found[i].pose.score, found[i - 1].pose.score);
    }
    for (std::size_t j = 0; j < i; ++j) {
      const auto at = [&](const PlanHypothesis& h) -> PlacePose {
        const Eigen::Vector3d p = poseFromYaw({h.pose.x, h.pose.y, 0}, h.pose.yaw) * centre;
        return {p.x(), p.y(), h.pose.yaw, 0};
      };
      EXPECT_FALSE(samePlace(at(found[i]), at(found[j])));
    }
  }
}

TEST(PlanPlaces, PriorsExcludeWhatTheyExclude) {
  const PlanTown town = randomTown(5);
  const PlanPlaces places = indexOf(town);
  const MovedQuery moved(town, {50, 0}, 30, poseFromYaw({10, 20, 0}, 0.4));
  const Eigen::Vector3d centre =
      moved.truth * Eigen::Vector3d(moved.query.centre.x(), moved.query.centre.y(), 0);
  PlacePrior here, elsewhere, wrong_way, right_way;
  here.near = PlacePrior::Circle{centre.x() + 4, centre.y() - 3, 10};
  elsewhere.near = PlacePrior::Circle{centre.x() - 100, centre.y(), 30};
  wrong_way.heading = PlacePrior::Heading{0.4 + M_PI, 0.5};
  right_way.heading = PlacePrior::Heading{0.5, 0.3};
  for (const PlacePrior& prior : {here, right_way}) {
    const auto found = places.search(moved.query, prior, 1);
    ASSERT_FALSE(found.empty());
    EXPECT_LT(errorOf(found[0], moved).metres, 0.25);
  }
  for (const PlanHypothesis& h : places.search(moved.query, elsewhere, 1)) {
    EXPECT_GT(errorOf(h, moved).metres, 50);
  }
  for (const PlanHypothesis& h : places.search(moved.query, wrong_way, 1)) {
    EXPECT_GT(errorOf(h, moved).degrees, 90);
  }
}

TEST(PlanPlaces, NothingIsFoundInAnEmptyMapOrForAnEmptyQuery) {
  const PlanPlaces nowhere(PlanView(), {}, defaultLikelihoods(), {}, 1);
  EXPECT_TRUE(nowhere.empty());
  const PlanTown town = randomTown(5);
  const MovedQuery moved(town, {0, 0}, 30, Eigen::Isometry3d::Identity());
  EXPECT_TRUE(nowhere.search(moved.query, {}, 1).empty());
  const PlanPlaces places = indexOf(town);
  EXPECT_FALSE(places.empty());
  const PlanQuery nothing = makePlanQuery(PlanView());
  EXPECT_TRUE(nothing.empty());
  EXPECT_TRUE(places.search(nothing, {}, 1).empty());
}

TEST(PlanPlaces, ARepetitiveTownHasTwoNearlyEqualPlaces) {
  Random random(4);
  PlanTown town;
  town.street(-120, -20, 0, random);
  town.repeat(130, 0);
  const PlanPlaces places(wholeTown(town), driveThrough(), defaultLikelihoods(), {}, 1);
  const MovedQuery moved(town, {-70, 0}, 30, poseFromYaw({10, 20, 0}, 1.2));
  const auto found = places.search(moved.query, {}, 1);
  ASSERT_GE(found.size(), 2u);
  EXPECT_GT(found[1].pose.score, 0.9 * found[0].pose.score);
  const bool first = errorOf(found[0], moved).metres < 0.5;
  EXPECT_LT(errorOf(found[first ? 0 : 1], moved).metres, 0.5);
  EXPECT_NEAR(errorOf(found[first ? 1 : 0], moved).metres, 130, 0.5);
}

TEST(PlanPlaces, AMirroredQueryScoresClearlyLower) {
  const PlanTown town = randomTown(5), mirror = town.mirrored();
  const PlanPlaces places = indexOf(town);
  const MovedQuery right(town, {20, 0}, 30, poseFromYaw({10, 20, 0}, 0.4));
  const MovedQuery wrong(mirror, {20, 0}, 30, poseFromYaw({10, 20, 0}, 0.4));
  const auto found = places.search(right.query, {}, 1),
             mirrored = places.search(wrong.query, {}, 1);
  ASSERT_FALSE(found.empty());
  if (mirrored.empty()) return;
  EXPECT_LT(mirrored[0].pose.score, 0.7 * found[0].pose.score);
}

TEST(PlanPlaces, EvidenceAddsUpToTheScoreOfThePose) {
  const PlanTown town = randomTown(5);
  const PlanPlaces places = indexOf(town);
  const MovedQuery moved(town, {20, 45}, 30, poseFromYaw({12, -7, 3}, 0.9));
  const auto found = places.search(moved.query, {}, 1);
  ASSERT_FALSE(found.empty());
  double nats = 0, expected = 0, standing = 0;
  for (const SampleEvidence& e : places.evidence(moved.query, found[0].pose)) {
    nats += e.nats;
    expected += e.expected;
    if ((e.channel >= Channel::building && e.channel <= Channel::other_surface) ||
        e.channel == Channel::obstacle_low || e.channel == Channel::obstacle_high) {
      standing += e.nats;
    }
    const Eigen::Vector3d q(e.query.x(), e.query.y(), 0);
    const Eigen::Vector3d p =
        poseFromYaw({found[0].pose.x, found[0].pose.y, 0}, found[0].pose.yaw) * q;
    EXPECT_LT((p.head<2>() - e.map).norm(), 1e-6);
    if (e.distance_bin == kUnknownBin) {
      EXPECT_EQ(e.nats, 0);
    }
  }
  EXPECT_NEAR(nats, found[0].pose.score, 1e-3);
  EXPECT_NEAR(expected, found[0].expected, 1e-3);
  EXPECT_NEAR(standing, found[0].standing.score, 1e-3);
  EXPECT_GT(found[0].standing.expected, 0);
}

TEST(PlanPlaces, UnseenAreaNeitherHelpsNorHarms) {
  const PlanTown town = randomTown(5);
  const PlanPlaces places = indexOf(town);
  const MovedQuery moved(town, {20, 0}, 30, Eigen::Isometry3d::Identity());
  EXPECT_EQ(places.score(moved.query, {5000, 5000, 0.3, 0}), 0);
  const PlanHypothesis far = places.verify(moved.query, {5000, 5000, 0.3, 0});
  EXPECT_EQ(far.pose.score, 0);
  EXPECT_EQ(far.known_share, 0);
  EXPECT_EQ(far.objects, 0);
}

TEST(PlanPlaces, VerifyClimbsToThePlaceBesideTheProposal) {
  const PlanTown town = randomTown(5);
  const PlanPlaces places = indexOf(town);
  const MovedQuery moved(town, {20, 0}, 30, poseFromYaw({10, 20, 3}, 0.4));
  const Eigen::Vector3d t = moved.truth.translation();
  const PlacePose proposed{t.x() + 1.2, t.y() - 0.8, 0.4 + 0.02, 0};
  const PlanHypothesis verified = places.verify(moved.query, proposed);
  EXPECT_LT(errorOf(verified, moved).metres, 0.25);
  EXPECT_GT(verified.pose.score, places.score(moved.query, proposed));
  EXPECT_NEAR(verified.pose.score, places.score(moved.query, verified.pose),
              1e-6 * verified.pose.score);
  EXPECT_GT(verified.objects, 3);
  EXPECT_GE(verified.objects_matched, verified.objects - 1);
}

TEST(PlanPlaces, AnyCoarseCellFindsThePlace) {
  const PlanTown town = randomTown(7);
  const MovedQuery moved(town, {-30, -45}, 30, poseFromYaw({10, 20, 3}, -2.4));
  for (const double cell_m : {1.0, 1.5, 3.0, 4.0}) {
    PlaceOptions options;
    options.coarse_cell_m = cell_m;
    const auto found = indexOf(town, options).search(moved.query, {}, 1);
    ASSERT_FALSE(found.empty()) << cell_m;
    EXPECT_LT(errorOf(found[0], moved).metres, 0.25) << cell_m;
  }
}

TEST(PlanQuery, HoldsOneSamplePerBlockOfSurfaceAndAllObjects) {
  PlanTown town;
  town.area(Channel::road, -10.01, -6.01, 9.99, 5.99);
  town.line(Channel::fence, -12, 8.1, 11.9, 8.1);
  for (int i = 0; i < 5; ++i) town.object(Channel::pole, i, 7);
  const PlanQuery query = makePlanQuery(town.view({0, 0}, 50, Eigen::Isometry3d::Identity()));
  const auto count = [](const std::vector<PlanQuery::Sample>& samples, Channel c) {
    return std::count_if(samples.begin(), samples.end(),
                         [c](const auto& s) { return s.channel == static_cast<std::size_t>(c); });
  };
  EXPECT_EQ(count(query.fine, Channel::fence), 8);
  EXPECT_EQ(count(query.coarse, Channel::fence), 4);
  for (const auto& s : query.fine) {
    if (s.channel != static_cast<std::size_t>(Channel::fence)) continue;
    const double x = s.x + query.centre.x();
    EXPECT_NEAR(x - 3 * std::floor(x / 3), 1.5, 0.3) << "nearest to the middle of its block";
  }
  EXPECT_EQ(count(query.fine, Channel::pole), 5);
  EXPECT_EQ(count(query.coarse, Channel::pole), 5);
  EXPECT_GT(count(query.fine, Channel::road), 2 * count(query.coarse, Channel::road));
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const auto& s : query.fine) sum += Eigen::Vector2d(s.x, s.y);
  EXPECT_LT(sum.norm(), 1e-3) << "samples are about their centre";
  EXPECT_EQ(query.viewpoint, Viewpoint::ground);
}

TEST(PlanQuery, KnowsWhatLiesLeftAndRightOfTheWay) {
  PlanTown town;
  town.area(Channel::road, -30, -4, 30, 4);
  town.line(Channel::fence, -30, 8, 30, 8);
  town.line(Channel::building, -30, -9, 30, -9);
  const PlanView view = town.view({0, 0}, 50, Eigen::Isometry3d::Identity());
  const std::vector<Eigen::Vector2d> east = {{-20, 0}, {-19.9, 0}, {0, 0}, {20, 0}},
                                     west = {{20, 0}, {0, 0}, {-20, 0}};
  const auto sideOfFence = [&](const std::vector<Eigen::Vector2d>& way) {
    const PlanQuery query = makePlanQuery(view, way);
    WaySide fence = WaySide::none;
    for (const auto& s : query.fine) {
      const auto channel = static_cast<Channel>(s.channel);
      if (channel == Channel::fence) fence = s.side;
      if (channel == Channel::building && fence != WaySide::none) {
        EXPECT_NE(s.side, fence);
      }
    }
    return fence;
  };
  EXPECT_EQ(sideOfFence(east), WaySide::left);
  EXPECT_EQ(sideOfFence(west), WaySide::right);
  EXPECT_EQ(sideOfFence({}), WaySide::none);
  EXPECT_EQ(sideOfFence({{0, 0}, {0.1, 0}, {0, 0.1}}), WaySide::none)
      << "standing still has no direction";
}

TEST(PlanPlaces, TheSidesOfTheWayShareTheScore) {
  const PlanTown town = randomTown(5);
  const PlanPlaces places = indexOf(town);
  const PlanView view = town.view({20, 45}, 30, Eigen::Isometry3d::Identity());
  const auto found = places.search(makePlanQuery(view, {{0, 45}, {20, 45}, {40, 46}}), {}, 1);
  ASSERT_FALSE(found.empty());
  const auto& [left, right] = found[0].sides;
  EXPECT_NEAR(left.score + right.score, found[0].pose.score, 1e-3);
  EXPECT_NEAR(left.expected + right.expected, found[0].expected, 1e-3);
  EXPECT_GT(left.expected, 0);
  EXPECT_GT(right.expected, 0);
  const PlanQuery still = makePlanQuery(view);
  EXPECT_EQ(places.search(still, {}, 1)[0].sides[0].expected, 0);
}

TEST(PlanPlaces, DescribesAPoseWithoutMovingIt) {
  const PlanTown town = randomTown(5);
  const PlanPlaces places = indexOf(town);
  const MovedQuery moved(town, {20, 45}, 30, poseFromYaw({12, -7, 3}, 0.9));
  PlacePose beside = places.search(moved.query, {}, 1)[0].pose;
  beside.x += 0.7;
  const PlanHypothesis described = places.describe(moved.query, beside);
  EXPECT_NEAR(described.pose.x, beside.x, 1e-9);
  EXPECT_NEAR(described.pose.y, beside.y, 1e-9);
  EXPECT_EQ(described.pose.score, places.score(moved.query, beside));
}

}  // namespace
}  // namespace xview::test
