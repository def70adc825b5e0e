// SPDX-License-Identifier: BSD-3-Clause
#include "search/search.h"

#include "search/surface_query.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "base/pose.h"
#include "bev_town.h"

namespace xview::search {
using namespace test;
namespace {

constexpr double kDegree = M_PI / 180;

BevGrid wholeTown(const BevTown& town) {
  return town.view(Eigen::Vector2d::Zero(), 150, Eigen::Isometry3d::Identity());
}

/// A field of a BEV grid, asked for views.
class Index {
 public:
  Index(const BevGrid& map, const std::vector<Eigen::Vector3d>& drive = {},
        const SearchOptions& options = {}, int threads = 1)
      : options_(options),
        field_(makeSurfaceField(map, drive, Surroundings::town, {}, options, threads)) {}

  std::unique_ptr<FieldQuery> prepare(const BevGrid& query) const {
    return field_->prepare({&query, nullptr, {}});
  }
  /// The prior is one of the centre of the query.
  std::vector<PlaceHypothesis> search(const BevGrid& query, const PlacePrior& prior = {},
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

Index indexOf(const BevTown& town, const SearchOptions& options = {}) {
  return Index(wholeTown(town), driveThrough(), options);
}

/// A query of `radius` about a place of the town in a frame of its own.
struct MovedQuery {
  MovedQuery(const BevTown& town, const Eigen::Vector2d& place, double radius_m,
             const Eigen::Isometry3d& T_town_query)
      : truth(T_town_query), query(town.view(place, radius_m, T_town_query.inverse())) {}
  Eigen::Isometry3d truth;  ///< query frame to town
  BevGrid query;
};

/// Error of a hypothesis at the query centre [m] and in heading [deg].
struct PoseError {
  double metres, degrees;
};
PoseError errorOf(const PlaceHypothesis& h, const BevGrid& query, const Eigen::Isometry3d& truth) {
  const SurfaceSamples samples = surfaceSamples(query);
  const Eigen::Vector3d centre(samples.centre.x(), samples.centre.y(), 0);
  return {((h.T_map_query * centre) - (truth * centre)).head<2>().norm(),
          std::abs(angleDifference(h.centre.yaw, yawOf(truth.linear()))) / kDegree};
}
PoseError errorOf(const PlaceHypothesis& h, const MovedQuery& moved) {
  return errorOf(h, moved.query, moved.truth);
}

TEST(SurfaceField, FindsAPlaceAgainAfterAnyMotionOfTheQuery) {
  const BevTown town = randomTown(5);
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
    EXPECT_GT(found[0].map_coverage, 0.99);
    EXPECT_GT(found[0].score(), 0.7 * found[0].expected);
    if (found.size() > 1) {
      EXPECT_GT(found[0].score(), found[1].score() + 60);
    }
  }
}

/// Of a map of more than 400 tiles cells of twice the size are looked at first.
TEST(SurfaceField, FindsAPlaceInALargeMap) {
  Random random(12);
  BevTown town;
  for (int street = -6; street <= 6; ++street) town.street(-360, 360, 60.0 * street, random);
  const BevGrid map = town.view({0, 0}, 400, Eigen::Isometry3d::Identity());
  const Index places(map);
  for (const double y : {-240.0, 60.0, 300.0}) {
    const Eigen::Vector2d place(random.uniform(-200, 200), y);
    const MovedQuery moved(town, place, 30,
                           poseFromYaw({random.uniform(-500, 500), 20, 3}, random.uniform(-3, 3)));
    const auto found = places.search(moved.query, {}, 2);
    ASSERT_FALSE(found.empty());
    EXPECT_LT(errorOf(found[0], moved).metres, 0.25) << y;
    EXPECT_GT(found[0].score(), 0.7 * found[0].expected) << y;
  }
}

TEST(SurfaceField, FindsAPlaceInAMapFarFromItsOrigin) {
  const BevTown town = randomTown(5);
  // Map frame = town frame + (4e6, -5e5): plan origins carry the large part.
  const Eigen::Isometry3d T_map_town = poseFromYaw({4e6, -5e5, 100}, 0);
  BevGrid map = town.view(Eigen::Vector2d::Zero(), 150, T_map_town, 4e6, -5e5);
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
  const BevTown town = randomTown(5);
  BevGrid map = wholeTown(town);
  map.origin_z = 64;
  for (GroundCell& cell : map.known) cell.z -= 64;
  const MovedQuery moved(town, {20, 45}, 30, poseFromYaw({3, -8, 250}, 0.7));
  BevGrid view = town.view({20, 45}, 30, moved.truth.inverse());
  for (const BevChannel c : {BevChannel::road, BevChannel::sidewalk, BevChannel::terrain})
    view[c].clear();
  const auto found = Index(map).search(view);
  ASSERT_FALSE(found.empty());
  EXPECT_LT(errorOf(found[0], moved).metres, 0.5);
  EXPECT_NEAR(found[0].T_map_query.translation().z(), moved.truth.translation().z(), 1);
}

TEST(SurfaceField, SearchGivesTheSameBytesForAnyNumberOfThreads) {
  const BevTown town = randomTown(6);
  const BevGrid map = wholeTown(town);
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
  const BevTown town = randomTown(6);
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
  const BevTown town = randomTown(5);
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
  const Index nowhere{BevGrid()};
  EXPECT_TRUE(nowhere.empty());
  const BevTown town = randomTown(5);
  const MovedQuery moved(town, {0, 0}, 30, Eigen::Isometry3d::Identity());
  EXPECT_TRUE(nowhere.search(moved.query, {}, 1).empty());
  const Index places = indexOf(town);
  EXPECT_FALSE(places.empty());
  EXPECT_TRUE(places.prepare(BevGrid())->empty());
  EXPECT_TRUE(places.search(BevGrid()).empty());
}

TEST(SurfaceField, ARepetitiveTownHasTwoNearlyEqualPlaces) {
  Random random(4);
  BevTown town;
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
  const BevTown town = randomTown(5), mirror = town.mirrored();
  const Index places = indexOf(town);
  const MovedQuery right(town, {20, 0}, 30, poseFromYaw({10, 20, 0}, 0.4));
  const MovedQuery wrong(mirror, {20, 0}, 30, poseFromYaw({10, 20, 0}, 0.4));
  const auto found = places.search(right.query), mirrored = places.search(wrong.query);
  ASSERT_FALSE(found.empty());
  if (mirrored.empty()) return;
  EXPECT_LT(mirrored[0].score(), 0.7 * found[0].score());
}

TEST(SurfaceField, EvidenceAddsUpToTheScoreOfThePose) {
  const BevTown town = randomTown(5);
  const Index places = indexOf(town);
  const MovedQuery moved(town, {20, 45}, 30, poseFromYaw({12, -7, 3}, 0.9));
  const auto found = places.search(moved.query);
  ASSERT_FALSE(found.empty());
  double nats = 0, expected = 0, standing = 0;
  for (const SampleEvidence& e : places.prepare(moved.query)->evidence(found[0].T_map_query)) {
    nats += e.nats;
    expected += e.expected;
    if ((e.channel >= BevChannel::building && e.channel <= BevChannel::other_surface) ||
        e.channel == BevChannel::obstacle_low || e.channel == BevChannel::obstacle_high) {
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
  EXPECT_NEAR(standing, found[0].obstacles.score, 1e-3);
  EXPECT_GT(found[0].obstacles.expected, 0);
}

TEST(SurfaceField, UnseenAreaNeitherHelpsNorHarms) {
  const BevTown town = randomTown(5);
  const Index places = indexOf(town);
  const MovedQuery moved(town, {20, 0}, 30, Eigen::Isometry3d::Identity());
  const auto query = places.prepare(moved.query);
  const Eigen::Isometry3d T = poseFromYaw({5000, 5000, 0}, 0.3);
  EXPECT_EQ(query->score(T), 0);
  const PlaceHypothesis far = query->verify(T);
  EXPECT_EQ(far.score(), 0);
  EXPECT_EQ(far.map_coverage, 0);
  EXPECT_EQ(far.matched, 0);
}

TEST(SurfaceField, AQueryShowsWhatStandsThereWhateverItsLabel) {
  const BevTown town = randomTown(5);
  const Index places = indexOf(town);
  const MovedQuery moved(town, {20, 45}, 30, poseFromYaw({12, -7, 3}, 0.9));
  const auto asked = [&](const BevGrid& query) {
    return places.prepare(query)->visibility(moved.truth);
  };
  const Visibility seen = asked(moved.query);
  ASSERT_TRUE(seen.map_overlap && seen.miss_ratio);
  EXPECT_GT(*seen.map_overlap, 0.4);
  EXPECT_LT(*seen.miss_ratio, 0.15);
  EXPECT_GT(seen.obstacle_overlap.value(), 0.8);

  BevGrid of_other_labels = moved.query;
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    if (c != static_cast<std::size_t>(BevChannel::obstacle_low) &&
        c != static_cast<std::size_t>(BevChannel::obstacle_high) &&
        c != static_cast<std::size_t>(BevChannel::road))
      of_other_labels.samples[c].clear();
  }
  const Visibility unlabelled = asked(of_other_labels);
  EXPECT_NEAR(*unlabelled.map_overlap, *seen.map_overlap, 0.02);
  EXPECT_NEAR(*unlabelled.miss_ratio, *seen.miss_ratio, 0.02);
  EXPECT_NEAR(*unlabelled.obstacle_overlap, *seen.obstacle_overlap, 0.02);

  BevGrid bare = moved.query;
  bare[BevChannel::obstacle_low].clear();
  bare[BevChannel::obstacle_high].clear();
  EXPECT_LT(*asked(bare).map_overlap, -0.4) << "it saw that nothing stands there";
  EXPECT_GT(*asked(bare).miss_ratio, 0.8);
  EXPECT_EQ(*asked(bare).obstacle_overlap, 1) << "nothing speaks against the map";
  for (GroundCell& cell : bare.known) cell.measured = false;
  EXPECT_FALSE(asked(bare).map_overlap) << "it has measured no ground";
  EXPECT_FALSE(asked(bare).miss_ratio);
  bare.known.clear();
  EXPECT_FALSE(asked(bare).map_overlap) << "it saw nothing of the place";
}

TEST(SurfaceField, AQueryOfOtherStreetsDoesNotShowWhatStandsInTheMap) {
  const Index places = indexOf(randomTown(5));
  const MovedQuery negative(randomTown(6), {20, 45}, 30, poseFromYaw({12, -7, 3}, 0.9));
  const auto query = places.prepare(negative.query);
  const auto found = places.search(negative.query);
  ASSERT_FALSE(found.empty());
  const Visibility seen = query->visibility(found[0].T_map_query);
  EXPECT_LT(seen.map_overlap.value(), 0.2);
  EXPECT_GT(seen.conflict_ratio.value(), 0.2);
}

TEST(SurfaceField, WhatStandsElsewhereInHalfOfAQueryIsContradictedThereOnly) {
  const BevTown town = randomTown(5);
  const Index places = indexOf(town);
  const MovedQuery moved(town, {20, 45}, 30, poseFromYaw({12, -7, 3}, 0.9));
  const auto conflict_ratio = [&](const BevGrid& query) {
    return places.prepare(query)->visibility(moved.truth).conflict_ratio.value();
  };
  const double of_whole = conflict_ratio(moved.query);
  EXPECT_LT(of_whole, 0.15);

  // A town that is a copy of this one, but for what stands in one half: it has moved by 12 m.
  BevGrid copy = moved.query;
  float middle = 0;
  for (const BevSample& s : copy[BevChannel::building])
    middle += s.x / static_cast<float>(copy[BevChannel::building].size());
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    if (isArea(static_cast<BevChannel>(c))) continue;
    for (BevSample& s : copy.samples[c]) {
      if (s.x < middle) s.y += 12;
    }
  }
  EXPECT_GT(conflict_ratio(copy), of_whole + 0.1);
  const Visibility whole = places.prepare(moved.query)->visibility(moved.truth),
                   other = places.prepare(copy)->visibility(moved.truth);
  EXPECT_LT(*other.obstacle_overlap, *whole.obstacle_overlap - 0.2);
  EXPECT_GT(*other.miss_ratio, *whole.miss_ratio + 0.1);

  BevGrid ground_only = moved.query;
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    if (!isArea(static_cast<BevChannel>(c))) ground_only.samples[c].clear();
  }
  EXPECT_EQ(conflict_ratio(ground_only), 0.25) << "where nothing stands nothing is told";
}

TEST(SurfaceField, VerifyClimbsToThePlaceBesideTheProposal) {
  const BevTown town = randomTown(5);
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
  const BevTown town = randomTown(7);
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
  BevTown town;
  town.area(BevChannel::road, -10.01, -6.01, 9.99, 5.99);
  town.line(BevChannel::fence, -12, 8.1, 11.9, 8.1);
  for (int i = 0; i < 5; ++i) town.object(BevChannel::pole, i, 7);
  const SurfaceSamples query = surfaceSamples(town.view({0, 0}, 50, Eigen::Isometry3d::Identity()));
  const auto count = [](const std::vector<SurfaceSamples::Sample>& samples, BevChannel c) {
    return std::count_if(samples.begin(), samples.end(),
                         [c](const auto& s) { return s.channel == static_cast<std::size_t>(c); });
  };
  EXPECT_EQ(count(query.fine, BevChannel::fence), 8);
  EXPECT_EQ(count(query.coarse, BevChannel::fence), 4);
  for (const auto& s : query.fine) {
    if (s.channel != static_cast<std::size_t>(BevChannel::fence)) continue;
    const double x = s.x + query.centre.x();
    EXPECT_NEAR(x - 3 * std::floor(x / 3), 1.5, 0.3) << "nearest to the middle of its block";
  }
  EXPECT_EQ(count(query.fine, BevChannel::pole), 5);
  EXPECT_EQ(count(query.coarse, BevChannel::pole), 5);
  EXPECT_GT(count(query.fine, BevChannel::road), 2 * count(query.coarse, BevChannel::road));
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const auto& s : query.fine) sum += Eigen::Vector2d(s.x, s.y);
  EXPECT_LT(sum.norm(), 1e-3) << "samples are about their centre";
  EXPECT_FALSE(query.aerial);
}

TEST(SurfaceField, DescribesAPoseWithoutMovingIt) {
  const BevTown town = randomTown(5);
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
BevTown longTown(std::uint64_t seed) {
  Random random(seed);
  BevTown town;
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
                       static_cast<std::uint8_t>(random.below(kBevChannels))});
  }
  return samples;
}

TEST(WideQuery, IsFoundToTheFractionOfADegreeThatItsRimNeeds) {
  const BevTown town = longTown(3);
  const Index places(town.view({0, 0}, 600, Eigen::Isometry3d::Identity()));
  const Eigen::Isometry3d T_town_query = poseFromYaw({700, -300, 5}, 2.1);
  const BevGrid view = town.view({30, 10}, 400, T_town_query.inverse());
  const auto query = places.prepare(view);
  ASSERT_GT(query->radius(), 300);
  const auto found = places.search(view);
  ASSERT_FALSE(found.empty());
  for (const Eigen::Vector2d& rim : {Eigen::Vector2d(-350, 0), Eigen::Vector2d(400, 70)}) {
    const Eigen::Vector3d in_query = T_town_query.inverse() * Eigen::Vector3d(rim.x(), rim.y(), 0);
    EXPECT_LT(((found[0].T_map_query * in_query).head<2>() - rim).norm(), 0.5);
  }
  EXPECT_NEAR(found[0].score(), query->score(found[0].T_map_query), 1e-6 * found[0].score());
  EXPECT_GT(found[0].map_coverage, 0.99);
  if (found.size() > 1) {
    EXPECT_GT(found[0].score(), 2 * found[1].score());
  }
}

TEST(WideQuery, OfAnotherTownFitsLittle) {
  const Index places(longTown(3).view({0, 0}, 600, Eigen::Isometry3d::Identity()));
  const BevGrid view = longTown(4).view({0, 0}, 400, Eigen::Isometry3d::Identity());
  const double expected = places.prepare(view)->describe(Eigen::Isometry3d::Identity()).expected;
  for (const PlaceHypothesis& h : places.search(view)) EXPECT_LT(h.score(), 0.5 * expected);
}

TEST(WideQuery, PriorOfItsCentreHolds) {
  const BevTown town = longTown(3);
  const Index places(town.view({0, 0}, 600, Eigen::Isometry3d::Identity()));
  const BevGrid view = town.view({0, 0}, 400, Eigen::Isometry3d::Identity());
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
