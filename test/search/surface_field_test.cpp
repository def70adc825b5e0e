// SPDX-License-Identifier: BSD-3-Clause
#include "xview/search/search.h"

#include "search/surface_query.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "bev_town.h"
#include "xview/types/pose.h"

namespace xview::search {
using namespace test;
namespace {

constexpr double kDegree = M_PI / 180;

PlanView wholeTown(const PlanTown& town) {
  return town.view(Eigen::Vector2d::Zero(), 150, Eigen::Isometry3d::Identity());
}

/// A field of a view from above, asked for views.
class Index {
 public:
  Index(const PlanView& map, const std::vector<Eigen::Vector3d>& drive = {},
        const SearchOptions& options = {}, int threads = 1)
      : options_(options), field_(makeSurfaceField(map, drive, Surroundings::town, options, threads)) {}

  std::unique_ptr<FieldQuery> prepare(const PlanView& query) const {
    return field_->prepare({&query, nullptr, {}});
  }
  /// The prior is one of the centre of the query.
  std::vector<PlaceHypothesis> search(const PlanView& query, const PlacePrior& prior = {},
                                      int threads = 1) const {
    const Eigen::Vector3d centre = prepare(query)->centre();
    return search::search(*field_->prepare({&query, nullptr, centre}), {prior}, options_, threads)
        .places;
  }
  bool empty() const { return field_->empty(); }

 private:
  SearchOptions options_;
  std::unique_ptr<const Field> field_;
};

Index indexOf(const PlanTown& town, const SearchOptions& options = {}) {
  return Index(wholeTown(town), driveThrough(), options);
}

/// A query of `radius` about a place of the town in a frame of its own.
struct MovedQuery {
  MovedQuery(const PlanTown& town, const Eigen::Vector2d& place, double radius_m,
             const Eigen::Isometry3d& T_town_query)
      : truth(T_town_query), query(town.view(place, radius_m, T_town_query.inverse())) {}
  Eigen::Isometry3d truth;  ///< query frame to town
  PlanView query;
};

/// Error of a hypothesis at the query centre [m] and in heading [deg].
struct PoseError {
  double metres, degrees;
};
PoseError errorOf(const PlaceHypothesis& h, const PlanView& query, const Eigen::Isometry3d& truth) {
  const SurfaceSamples samples = surfaceSamples(query);
  const Eigen::Vector3d centre(samples.centre.x(), samples.centre.y(), 0);
  return {((h.T_map_query * centre) - (truth * centre)).head<2>().norm(),
          std::abs(angleDifference(h.centre.yaw, yawOf(truth.linear()))) / kDegree};
}
PoseError errorOf(const PlaceHypothesis& h, const MovedQuery& moved) {
  return errorOf(h, moved.query, moved.truth);
}

TEST(SurfaceField, FindsAPlaceAgainAfterAnyMotionOfTheQuery) {
  const PlanTown town = randomTown(5);
  const Index places = indexOf(town);
  Random random(9);
  for (int i = 0; i < 6; ++i) {
    const Eigen::Vector2d place(random.uniform(-80, 80),
                                45.0 * (static_cast<int>(random.below(3)) - 1));
    const Eigen::Isometry3d T =
        poseFromYaw({random.uniform(-500, 500), random.uniform(-500, 500), random.uniform(-20, 20)},
                    random.uniform(-M_PI, M_PI));
    const MovedQuery moved(town, place, 30, T);
    const auto found = places.search(moved.query);
    ASSERT_FALSE(found.empty());
    const PoseError error = errorOf(found[0], moved);
    EXPECT_LT(error.metres, 0.25) << "query " << i;
    EXPECT_LT(error.degrees, 0.5) << "query " << i;
    EXPECT_NEAR(found[0].T_map_query.translation().z(), T.translation().z(), 0.05) << "query " << i;
    EXPECT_GT(found[0].known_share, 0.99);
    EXPECT_GT(found[0].score(), 0.7 * found[0].expected);
    if (found.size() > 1) {
      EXPECT_GT(found[0].score(), found[1].score() + 60);
    }
  }
}

TEST(SurfaceField, FindsAPlaceInAMapFarFromItsOrigin) {
  const PlanTown town = randomTown(5);
  // Map frame = town frame + (4e6, -5e5): plan origins carry the large part.
  const Eigen::Isometry3d T_map_town = poseFromYaw({4e6, -5e5, 100}, 0);
  PlanView map = town.view(Eigen::Vector2d::Zero(), 150, T_map_town, 4e6, -5e5);
  map.origin_z = 64;
  for (GroundCell& cell : map.known) cell.z -= 64;
  const Index places(map);
  const MovedQuery moved(town, {20, 45}, 30, poseFromYaw({3, -8, 2}, 0.7));
  const auto found = places.search(moved.query);
  ASSERT_FALSE(found.empty());
  const Eigen::Isometry3d expected = T_map_town * moved.truth;
  const PoseError error = errorOf(found[0], moved.query, expected);
  EXPECT_LT(error.metres, 0.25);
  EXPECT_LT(error.degrees, 0.5);
  EXPECT_NEAR(found[0].T_map_query.translation().z(), expected.translation().z(), 0.05);
}

TEST(SurfaceField, KnowsTheHeightOfAQueryWithoutGround) {
  const PlanTown town = randomTown(5);
  PlanView map = wholeTown(town);
  map.origin_z = 64;
  for (GroundCell& cell : map.known) cell.z -= 64;
  const MovedQuery moved(town, {20, 45}, 30, poseFromYaw({3, -8, 250}, 0.7));
  PlanView view = town.view({20, 45}, 30, moved.truth.inverse());
  for (const Channel c : {Channel::road, Channel::sidewalk, Channel::terrain}) view[c].clear();
  const auto found = Index(map).search(view);
  ASSERT_FALSE(found.empty());
  EXPECT_LT(errorOf(found[0], moved).metres, 0.5);
  EXPECT_NEAR(found[0].T_map_query.translation().z(), moved.truth.translation().z(), 1);
}

TEST(SurfaceField, SearchGivesTheSameBytesForAnyNumberOfThreads) {
  const PlanTown town = randomTown(6);
  const PlanView map = wholeTown(town);
  const MovedQuery moved(town, {-40, 0}, 30, poseFromYaw({70, -20, 0}, 2.1));
  const auto run = [&](int threads) {
    return Index(map, driveThrough(), {}, threads).search(moved.query, {}, threads);
  };
  const auto one = run(1), two = run(2);
  ASSERT_EQ(one.size(), two.size());
  ASSERT_FALSE(one.empty());
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(std::memcmp(&one[i].centre, &two[i].centre, sizeof(PlacePose)), 0) << i;
    EXPECT_TRUE(one[i].T_map_query.matrix() == two[i].T_map_query.matrix()) << i;
    EXPECT_EQ(one[i].expected, two[i].expected);
  }
}

TEST(SurfaceField, BestFirstAndDistinct) {
  const PlanTown town = randomTown(6);
  const Index places = indexOf(town);
  const MovedQuery moved(town, {-40, 0}, 30, poseFromYaw({70, -20, 0}, 2.1));
  const auto found = places.search(moved.query);
  ASSERT_GT(found.size(), 1u);
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (i > 0) {
      EXPECT_LE(found[i].score(), found[i - 1].score());
    }
    for (std::size_t j = 0; j < i; ++j) EXPECT_FALSE(samePlace(found[i].centre, found[j].centre));
  }
}

TEST(SurfaceField, PriorsExcludeWhatTheyExclude) {
  const PlanTown town = randomTown(5);
  const Index places = indexOf(town);
  const MovedQuery moved(town, {50, 0}, 30, poseFromYaw({10, 20, 0}, 0.4));
  const Eigen::Vector3d centre = moved.truth * places.prepare(moved.query)->centre();
  PlacePrior here, elsewhere, wrong_way, right_way;
  here.near = PlacePrior::Circle{centre.x() + 4, centre.y() - 3, 10};
  elsewhere.near = PlacePrior::Circle{centre.x() - 100, centre.y(), 30};
  wrong_way.heading = PlacePrior::Heading{0.4 + M_PI, 0.5};
  right_way.heading = PlacePrior::Heading{0.5, 0.3};
  for (const PlacePrior& prior : {here, right_way}) {
    const auto found = places.search(moved.query, prior);
    ASSERT_FALSE(found.empty());
    EXPECT_LT(errorOf(found[0], moved).metres, 0.25);
  }
  for (const PlaceHypothesis& h : places.search(moved.query, elsewhere)) {
    EXPECT_GT(errorOf(h, moved).metres, 50);
  }
  for (const PlaceHypothesis& h : places.search(moved.query, wrong_way)) {
    EXPECT_GT(errorOf(h, moved).degrees, 90);
  }
}

TEST(SurfaceField, NothingIsFoundInAnEmptyMapOrForAnEmptyQuery) {
  const Index nowhere{PlanView()};
  EXPECT_TRUE(nowhere.empty());
  const PlanTown town = randomTown(5);
  const MovedQuery moved(town, {0, 0}, 30, Eigen::Isometry3d::Identity());
  EXPECT_TRUE(nowhere.search(moved.query, {}, 1).empty());
  const Index places = indexOf(town);
  EXPECT_FALSE(places.empty());
  EXPECT_TRUE(places.prepare(PlanView())->empty());
  EXPECT_TRUE(places.search(PlanView()).empty());
}

TEST(SurfaceField, ARepetitiveTownHasTwoNearlyEqualPlaces) {
  Random random(4);
  PlanTown town;
  town.street(-120, -20, 0, random);
  town.repeat(130, 0);
  const Index places = indexOf(town);
  const MovedQuery moved(town, {-70, 0}, 30, poseFromYaw({10, 20, 0}, 1.2));
  const auto found = places.search(moved.query);
  ASSERT_GE(found.size(), 2u);
  EXPECT_GT(found[1].score(), 0.9 * found[0].score());
  const bool first = errorOf(found[0], moved).metres < 0.5;
  EXPECT_LT(errorOf(found[first ? 0 : 1], moved).metres, 0.5);
  EXPECT_NEAR(errorOf(found[first ? 1 : 0], moved).metres, 130, 0.5);
}

TEST(SurfaceField, AMirroredQueryScoresClearlyLower) {
  const PlanTown town = randomTown(5), mirror = town.mirrored();
  const Index places = indexOf(town);
  const MovedQuery right(town, {20, 0}, 30, poseFromYaw({10, 20, 0}, 0.4));
  const MovedQuery wrong(mirror, {20, 0}, 30, poseFromYaw({10, 20, 0}, 0.4));
  const auto found = places.search(right.query), mirrored = places.search(wrong.query);
  ASSERT_FALSE(found.empty());
  if (mirrored.empty()) return;
  EXPECT_LT(mirrored[0].score(), 0.7 * found[0].score());
}

TEST(SurfaceField, EvidenceAddsUpToTheScoreOfThePose) {
  const PlanTown town = randomTown(5);
  const Index places = indexOf(town);
  const MovedQuery moved(town, {20, 45}, 30, poseFromYaw({12, -7, 3}, 0.9));
  const auto found = places.search(moved.query);
  ASSERT_FALSE(found.empty());
  double nats = 0, expected = 0, standing = 0;
  for (const SampleEvidence& e : places.prepare(moved.query)->evidence(found[0].T_map_query)) {
    nats += e.nats;
    expected += e.expected;
    if ((e.channel >= Channel::building && e.channel <= Channel::other_surface) ||
        e.channel == Channel::obstacle_low || e.channel == Channel::obstacle_high) {
      standing += e.nats;
    }
    const Eigen::Vector3d p = found[0].T_map_query * Eigen::Vector3d(e.query.x(), e.query.y(), 0);
    EXPECT_LT((p.head<2>() - e.map).norm(), 1e-6);
    if (!e.known) {
      EXPECT_EQ(e.nats, 0);
    }
  }
  EXPECT_NEAR(nats, found[0].score(), 1e-3);
  EXPECT_NEAR(expected, found[0].expected, 1e-3);
  EXPECT_NEAR(standing, found[0].standing.score, 1e-3);
  EXPECT_GT(found[0].standing.expected, 0);
}

TEST(SurfaceField, UnseenAreaNeitherHelpsNorHarms) {
  const PlanTown town = randomTown(5);
  const Index places = indexOf(town);
  const MovedQuery moved(town, {20, 0}, 30, Eigen::Isometry3d::Identity());
  const auto query = places.prepare(moved.query);
  const Eigen::Isometry3d T = poseFromYaw({5000, 5000, 0}, 0.3);
  EXPECT_EQ(query->score(T), 0);
  const PlaceHypothesis far = query->verify(T);
  EXPECT_EQ(far.score(), 0);
  EXPECT_EQ(far.known_share, 0);
  EXPECT_EQ(far.matched, 0);
}

TEST(SurfaceField, AQueryShowsWhatStandsThereWhateverItsLabel) {
  const PlanTown town = randomTown(5);
  const Index places = indexOf(town);
  const MovedQuery moved(town, {20, 45}, 30, poseFromYaw({12, -7, 3}, 0.9));
  const auto asked = [&](const PlanView& query) {
    return places.prepare(query)->visibility(moved.truth);
  };
  const Visibility seen = asked(moved.query);
  ASSERT_TRUE(seen.shown && seen.missing);
  EXPECT_GT(*seen.shown, 0.4);
  EXPECT_LT(*seen.missing, 0.15);
  EXPECT_GT(seen.standing.value(), 0.8);

  PlanView of_other_labels = moved.query;
  for (std::size_t c = 0; c < kChannels; ++c) {
    if (c != static_cast<std::size_t>(Channel::obstacle_low) &&
        c != static_cast<std::size_t>(Channel::obstacle_high) &&
        c != static_cast<std::size_t>(Channel::road))
      of_other_labels.samples[c].clear();
  }
  const Visibility unlabelled = asked(of_other_labels);
  EXPECT_NEAR(*unlabelled.shown, *seen.shown, 0.02);
  EXPECT_NEAR(*unlabelled.missing, *seen.missing, 0.02);
  EXPECT_NEAR(*unlabelled.standing, *seen.standing, 0.02);

  PlanView bare = moved.query;
  bare[Channel::obstacle_low].clear();
  bare[Channel::obstacle_high].clear();
  EXPECT_LT(*asked(bare).shown, -0.4) << "it saw that nothing stands there";
  EXPECT_GT(*asked(bare).missing, 0.8);
  EXPECT_EQ(*asked(bare).standing, 1) << "nothing speaks against the map";
  for (GroundCell& cell : bare.known) cell.measured = false;
  EXPECT_FALSE(asked(bare).shown) << "it has measured no ground";
  EXPECT_FALSE(asked(bare).missing);
  bare.known.clear();
  EXPECT_FALSE(asked(bare).shown) << "it saw nothing of the place";
}

TEST(SurfaceField, AQueryOfOtherStreetsDoesNotShowWhatStandsInTheMap) {
  const Index places = indexOf(randomTown(5));
  const MovedQuery stranger(randomTown(6), {20, 45}, 30, poseFromYaw({12, -7, 3}, 0.9));
  const auto query = places.prepare(stranger.query);
  const auto found = places.search(stranger.query);
  ASSERT_FALSE(found.empty());
  const Visibility seen = query->visibility(found[0].T_map_query);
  EXPECT_LT(seen.shown.value(), 0.2);
  EXPECT_GT(seen.contradicted.value(), 0.2);
}

TEST(SurfaceField, WhatStandsElsewhereInHalfOfAQueryIsContradictedThereOnly) {
  const PlanTown town = randomTown(5);
  const Index places = indexOf(town);
  const MovedQuery moved(town, {20, 45}, 30, poseFromYaw({12, -7, 3}, 0.9));
  const auto contradicted = [&](const PlanView& query) {
    return places.prepare(query)->visibility(moved.truth).contradicted.value();
  };
  const double of_whole = contradicted(moved.query);
  EXPECT_LT(of_whole, 0.15);

  // A town that is a copy of this one, but for what stands in one half: it has moved by 12 m.
  PlanView copy = moved.query;
  float middle = 0;
  for (const PlanSample& s : copy[Channel::building])
    middle += s.x / static_cast<float>(copy[Channel::building].size());
  for (std::size_t c = 0; c < kChannels; ++c) {
    if (isArea(static_cast<Channel>(c))) continue;
    for (PlanSample& s : copy.samples[c]) {
      if (s.x < middle) s.y += 12;
    }
  }
  EXPECT_GT(contradicted(copy), of_whole + 0.1);
  const Visibility whole = places.prepare(moved.query)->visibility(moved.truth),
                   other = places.prepare(copy)->visibility(moved.truth);
  EXPECT_LT(*other.standing, *whole.standing - 0.2);
  EXPECT_GT(*other.missing, *whole.missing + 0.1);

  PlanView ground_only = moved.query;
  for (std::size_t c = 0; c < kChannels; ++c) {
    if (!isArea(static_cast<Channel>(c))) ground_only.samples[c].clear();
  }
  EXPECT_EQ(contradicted(ground_only), 0.25) << "where nothing stands nothing is told";
}

TEST(SurfaceField, VerifyClimbsToThePlaceBesideTheProposal) {
  const PlanTown town = randomTown(5);
  const Index places = indexOf(town);
  const MovedQuery moved(town, {20, 0}, 30, poseFromYaw({10, 20, 3}, 0.4));
  const Eigen::Vector3d t = moved.truth.translation();
  const Eigen::Isometry3d proposed = poseFromYaw({t.x() + 1.2, t.y() - 0.8, 0}, 0.4 + 0.02);
  const auto query = places.prepare(moved.query);
  const PlaceHypothesis verified = query->verify(proposed);
  EXPECT_LT(errorOf(verified, moved).metres, 0.25);
  EXPECT_GT(verified.score(), query->score(proposed));
  EXPECT_NEAR(verified.score(), query->score(verified.T_map_query), 1e-6 * verified.score());
  int objects = 0;
  for (const SampleEvidence& e : query->evidence(verified.T_map_query))
    objects += e.known && isObject(e.channel);
  EXPECT_GT(objects, 3);
  EXPECT_GE(verified.matched, objects - 1);
}

TEST(SurfaceField, AnyCoarseCellFindsThePlace) {
  const PlanTown town = randomTown(7);
  const MovedQuery moved(town, {-30, -45}, 30, poseFromYaw({10, 20, 3}, -2.4));
  for (const double cell_m : {1.0, 1.5, 3.0, 4.0}) {
    SearchOptions options;
    options.cell_m = cell_m;
    const auto found = indexOf(town, options).search(moved.query);
    ASSERT_FALSE(found.empty()) << cell_m;
    EXPECT_LT(errorOf(found[0], moved).metres, 0.25) << cell_m;
  }
}

TEST(SurfaceSamples, HoldsOneSamplePerBlockOfSurfaceAndAllObjects) {
  PlanTown town;
  town.area(Channel::road, -10.01, -6.01, 9.99, 5.99);
  town.line(Channel::fence, -12, 8.1, 11.9, 8.1);
  for (int i = 0; i < 5; ++i) town.object(Channel::pole, i, 7);
  const SurfaceSamples query = surfaceSamples(town.view({0, 0}, 50, Eigen::Isometry3d::Identity()));
  const auto count = [](const std::vector<SurfaceSamples::Sample>& samples, Channel c) {
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

TEST(SurfaceField, DescribesAPoseWithoutMovingIt) {
  const PlanTown town = randomTown(5);
  const Index places = indexOf(town);
  const MovedQuery moved(town, {20, 45}, 30, poseFromYaw({12, -7, 3}, 0.9));
  Eigen::Isometry3d beside = places.search(moved.query)[0].T_map_query;
  beside.translation().x() += 0.7;
  const auto query = places.prepare(moved.query);
  const PlaceHypothesis described = query->describe(beside);
  EXPECT_LT((described.T_map_query.translation() - beside.translation()).head<2>().norm(), 1e-9);
  EXPECT_EQ(described.score(), query->score(beside));
}

/// Two long streets that cross a third one.
PlanTown longTown(std::uint64_t seed) {
  Random random(seed);
  PlanTown town;
  town.street(-450, 450, 0, random);
  town.street(-300, 450, 70, random);
  town.street(-450, 200, -80, random);
  return town;
}

std::vector<SurfaceSamples::Sample> randomSamples(int count, double radius_m, Random& random) {
  std::vector<SurfaceSamples::Sample> samples;
  for (int i = 0; i < count; ++i) {
    samples.push_back({static_cast<float>(random.uniform(-radius_m, radius_m)),
                       static_cast<float>(random.uniform(-radius_m, radius_m)),
                       static_cast<std::uint8_t>(random.below(kChannels))});
  }
  return samples;
}

TEST(WideQuery, IsFoundToTheFractionOfADegreeThatItsRimNeeds) {
  const PlanTown town = longTown(3);
  const Index places(town.view({0, 0}, 600, Eigen::Isometry3d::Identity()));
  const Eigen::Isometry3d T_town_query = poseFromYaw({700, -300, 5}, 2.1);
  const PlanView view = town.view({30, 10}, 400, T_town_query.inverse());
  const auto query = places.prepare(view);
  ASSERT_GT(query->radius(), 300);
  const auto found = places.search(view);
  ASSERT_FALSE(found.empty());
  for (const Eigen::Vector2d& rim : {Eigen::Vector2d(-350, 0), Eigen::Vector2d(400, 70)}) {
    const Eigen::Vector3d in_query = T_town_query.inverse() * Eigen::Vector3d(rim.x(), rim.y(), 0);
    EXPECT_LT(((found[0].T_map_query * in_query).head<2>() - rim).norm(), 0.5);
  }
  EXPECT_NEAR(found[0].score(), query->score(found[0].T_map_query), 1e-6 * found[0].score());
  EXPECT_GT(found[0].known_share, 0.99);
  if (found.size() > 1) {
    EXPECT_GT(found[0].score(), 2 * found[1].score());
  }
}

TEST(WideQuery, OfAnotherTownFitsLittle) {
  const Index places(longTown(3).view({0, 0}, 600, Eigen::Isometry3d::Identity()));
  const PlanView view = longTown(4).view({0, 0}, 400, Eigen::Isometry3d::Identity());
  const double expected = places.prepare(view)->describe(Eigen::Isometry3d::Identity()).expected;
  for (const PlaceHypothesis& h : places.search(view)) EXPECT_LT(h.score(), 0.5 * expected);
}

TEST(WideQuery, PriorOfItsCentreHolds) {
  const PlanTown town = longTown(3);
  const Index places(town.view({0, 0}, 600, Eigen::Isometry3d::Identity()));
  const PlanView view = town.view({0, 0}, 400, Eigen::Isometry3d::Identity());
  const Eigen::Vector3d centre = places.prepare(view)->centre();
  PlacePrior prior;
  prior.near = PlacePrior::Circle{centre.x(), centre.y(), 5};
  const auto found = places.search(view, prior);
  ASSERT_FALSE(found.empty());
  EXPECT_LT(found[0].T_map_query.translation().head<2>().norm(), 0.5);
}

TEST(WideQuery, PartsAreThoseWithinTheirRadius) {
  Random random(1);
  SurfaceSamples whole;
  whole.centre = {3, 5};
  whole.fine = randomSamples(300, 100, random);
  const SurfaceSamples part = partOf(whole, {23, -25}, 40);
  EXPECT_EQ(part.centre, Eigen::Vector2d(23, -25));
  std::size_t next = 0;
  for (const SurfaceSamples::Sample& s : whole.fine) {
    if (std::hypot(s.x - 20, s.y + 30) > 40) continue;
    ASSERT_LT(next, part.fine.size());
    EXPECT_NEAR(part.fine[next].x + 20, s.x, 1e-4);
    EXPECT_NEAR(part.fine[next].y - 30, s.y, 1e-4);
    EXPECT_EQ(part.fine[next++].channel, s.channel);
  }
  EXPECT_EQ(next, part.fine.size());
}

}  // namespace
}  // namespace xview::search
