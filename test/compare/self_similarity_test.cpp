// SPDX-License-Identifier: BSD-3-Clause
#include "compare/self_similarity.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "localizer/two_streets.h"
#include "search/distance_field.h"
#include "support/label_sets.h"
#include "xview/base/semantic_place.h"

namespace xview {
namespace {

/// Two drives, one along each of two streets whose halves at x > 0 are copies.
map::SemanticMap copiedStreets() {
  map::SemanticMap map = test::mapOf(test::twoStreets(false));
  for (const Eigen::Isometry3d& T : map.poses)
    map.source_of_pose.push_back(T.translation().y() > 100);
  map.sources = {"a", "b"};
  return map;
}

const SelfSimilarity& measured() {
  static const SelfSimilarity self_similarity = [] {
    Options options;
    options.threads = 2;
    return measureSelfSimilarity(copiedStreets(), options, 12);
  }();
  return self_similarity;
}

TEST(SelfSimilarity, TellsCopiesFromWhatIsThereOnce) {
  int copies = 0, singles = 0;
  for (const SelfQuery& q : measured().queries) {
    const Eigen::Vector3d& p = measured().places[q.place].position;
    if (q.window_m > 30 || std::abs(p.x()) < 75) continue;  // what they see ends before x = 0
    if (p.x() < 0) {
      ++singles;
      EXPECT_LT(q.wrong, 0.97 * q.self) << p.transpose() << ", " << q.window_m << " m";
      continue;
    }
    EXPECT_FALSE(q.sure) << p.transpose() << ", " << q.window_m << " m";
    ++copies;
    ASSERT_TRUE(q.second_best);
    EXPECT_LT((*q.second_best - Eigen::Vector3d(p.x(), 200 - p.y(), q.second_best->z())).norm(), 3);
    EXPECT_GT(q.wrong, 0.99 * q.self);
  }
  EXPECT_GT(copies, 5);
  EXPECT_GT(singles, 5);
}

/// Places of a building of which two scanners stood somewhere are no positions in its two poses.
TEST(SelfSimilarity, PlacesOfFloorsThatNobodyWalkedThroughHaveNoKeyFrame) {
  map::SemanticMap map;
  map.labels = test::labelSetOf("rooms", {{1, "floor", Role::surface, Kind::terrain},
                                          {2, "wall", Role::surface, Kind::building}});
  map.size = kRoomScale;
  map.gravity.known = true;
  for (const double x : {2.0, 18.0})
    map.addKeyframe(Eigen::Isometry3d(Eigen::Translation3d(x, 0, 1.2)), 0, 0, 0);
  const auto add = [&](double x, double y, double z, std::uint32_t label) {
    map.cloud.points.push_back(Point(float(x), float(y), float(z), label));
  };
  for (const double bottom : {0.0, 3.0}) {
    for (double x = 0; x < 20; x += 0.1) {
      for (double y = -3; y <= 3; y += 0.1) add(x, y, bottom, 1), add(x, y, bottom + 2.6, 2);
      for (double z = 0.1; z < 2.6; z += 0.1) add(x, 3, bottom + z, 2), add(x, -3, bottom + z, 2);
    }
  }
  const SelfSimilarity found = measureSelfSimilarity(map, {}, 12);
  EXPECT_FALSE(found.places.empty());
  for (const SelfSimilarity::Place& place : found.places) EXPECT_FALSE(place.key_frame);
}

TEST(SelfSimilarity, PlacesAreSureFromALengthOnFromWhichAllAre) {
  for (std::size_t i = 0; i < measured().places.size(); ++i) {
    const SelfSimilarity::Place& place = measured().places[i];
    std::optional<double> from;
    for (const SelfQuery& q : measured().queries) {
      if (q.place != i) continue;
      if (!q.sure) from = std::nullopt;
      if (q.sure && !from) from = q.window_m;
    }
    EXPECT_EQ(place.min_query_length_m, from) << place.position.transpose();
  }
}

TEST(SelfSimilarity, IsTheSameForAnyNumberOfThreads) {
  Options options;
  options.threads = 1;
  const SelfSimilarity again = measureSelfSimilarity(copiedStreets(), options, 12);
  ASSERT_EQ(again.queries.size(), measured().queries.size());
  for (std::size_t i = 0; i < again.queries.size(); ++i) {
    EXPECT_EQ(again.queries[i].self, measured().queries[i].self);
    EXPECT_EQ(again.queries[i].wrong, measured().queries[i].wrong);
  }
}

TEST(SelfSimilarity, WrongScoresAreQuantilesByLength) {
  SelfSimilarity self_similarity;
  self_similarity.lengths_m = {8, 15};
  for (int i = 1; i <= 101; ++i) {
    SelfQuery query;
    query.window_m = 8;
    query.self = 1000;
    query.wrong = i;
    query.next_wrong = 1;
    self_similarity.queries.push_back(query);
  }
  const std::vector<WrongScores> scores = wrongScores(self_similarity);
  ASSERT_EQ(scores.size(), 1u);  // nothing is known of 15 m
  EXPECT_EQ(scores[0].queries, 101u);
  EXPECT_DOUBLE_EQ(scores[0].share[0], 0.051);
  EXPECT_DOUBLE_EQ(scores[0].share[3], 0.101);
  EXPECT_DOUBLE_EQ(scores[0].likelihood_margin[3], 100 * std::log(101.0));
}

/// What stands in the plan, as columns of points.
LabelledCloud columnsOf(const map::SemanticMap& map) {
  LabelledCloud cloud;
  for (const auto& samples : map.bev.samples) {
    for (const BevSample& s : samples) {
      for (const float up_m : {0.2F, 0.6F, 1.0F, 1.4F}) {
        Point point;
        point.x = static_cast<float>(map.bev.origin_x) + s.x;
        point.y = static_cast<float>(map.bev.origin_y) + s.y;
        point.z = static_cast<float>(map.bev.origin_z) + s.z + up_m;
        point.label = 1;
        point.sigma = 0.02F;
        cloud.points.push_back(point);
      }
    }
  }
  return cloud;
}

/// Half of the stretches lie in copies, where points lie on their like as at their own place.
TEST(SelfSimilarity, AtWrongPlacesOfCopiesPointsLieOnTheirLike) {
  map::SemanticMap map = copiedStreets();
  measureNullHypothesis(map, {});
  for (const WrongPlace& place : map.wrong_places)
    EXPECT_FALSE(place.above_null) << "a map without points";
  map.labels = test::labelSetOf("walls", {{1, "wall", Role::surface, Kind::building}});
  map.cloud = columnsOf(map);
  measureNullHypothesis(map, {});
  std::vector<double> excess;
  for (const WrongPlace& place : map.wrong_places) excess.push_back(place.above_null.value());
  ASSERT_GT(excess.size(), 20u);
  std::sort(excess.begin(), excess.end());
  const std::size_t quarter = excess.size() / 4;
  EXPECT_GT(excess[3 * quarter], excess[quarter] + 0.1);
  map::SemanticMap empty;
  empty.own_stretches = {{30, 1}};
  measureNullHypothesis(empty, {});
  EXPECT_TRUE(empty.own_stretches.empty());
}

TEST(SelfSimilarity, AMapOfCopiesHasWrongPlacesThatStandOut) {
  map::SemanticMap map;
  for (const double margin : {1., 2., 3., 4.}) map.wrong_places.push_back({{}, {}, margin, margin});
  EXPECT_FALSE(wrongPlaceMargins(map)) << "too few";
  map.wrong_places.push_back({{}, {}, 100., 500.});
  ASSERT_TRUE(wrongPlaceMargins(map));
  EXPECT_NEAR(wrongPlaceMargins(map)->dense, 2.5, 1e-12) << "without the largest";
  EXPECT_NEAR(wrongPlaceMargins(map)->likelihood, 2.5, 1e-12);
  EXPECT_FALSE(wrongPlaceMargins(map)->areOfCopies());
  map.wrong_places.insert(map.wrong_places.end(), 4, {{}, {}, 8., 20.});
  EXPECT_TRUE(wrongPlaceMargins(map)->areOfCopies()) << "points of other places fit as closely";
}

/// What is short beside the map is not asked, and the null stands for the map as it is now.
TEST(SelfSimilarity, OfManySmallAdditionsAFewAreAsked) {
  map::SemanticMap map = copiedStreets();
  measureNullHypothesis(map, {});
  const std::size_t whole = map.own_stretches.size(), poses = map.null.poses;
  std::size_t asked = 0, skipped = 0;
  for (int addition = 0; addition < 8; ++addition) {
    const std::size_t first = map.poses.size(), before = map.own_stretches.size();
    const Eigen::Isometry3d last = map.poses.back();
    const Eigen::Vector3d step = last.translation() - map.poses[first - 2].translation();
    map.addKeyframe(Eigen::Translation3d(step) * last, 0, 0, map.source_of_pose.back());
    map.bev[BevChannel::road].push_back({0, 0, 0});
    measureNullHypothesis(map, {}, first);
    const bool is_asked = map.own_stretches.size() > before;
    ++(is_asked ? asked : skipped);
    EXPECT_TRUE(is_asked || map.null.view == search::fingerprintOf(map.bev));
  }
  EXPECT_GT(skipped, asked);
  EXPECT_GE(map.own_stretches.size(), whole);
  EXPECT_GE(map.null.poses, poses);
}

TEST(SelfSimilarity, OwnStretchesAreAcceptedByLengthAndRisk) {
  map::SemanticMap map;
  map.own_stretches = {{30, 0.9995}, {15, 0.5}, {30, 0.99}, {15, 0.99995}, {30, 0.98}};
  const std::vector<OwnAcceptance> own = ownAcceptance(map);
  ASSERT_EQ(own.size(), 2u);
  EXPECT_EQ(own[0].window_m, 15);
  EXPECT_EQ(own[0].stretches, 2u);
  EXPECT_EQ(own[0].accepted, (std::array<std::size_t, 3>{1, 1, 1}));
  EXPECT_EQ(own[1].stretches, 3u);
  EXPECT_EQ(own[1].accepted, (std::array<std::size_t, 3>{2, 1, 0}));
  EXPECT_TRUE(ownAcceptance({}).empty());
}

TEST(SelfSimilarity, IsInMetresOfThePlace) {
  map::SemanticMap room = copiedStreets();
  scaleLengths(kRoomScale, room);
  room.size = kRoomScale;
  const SelfSimilarity in_room = measureSelfSimilarity(room, {}, 6);
  ASSERT_EQ(in_room.places.size(), 6u);
  EXPECT_EQ(in_room.lengths_m.front(), 2);
  for (const SelfSimilarity::Place& place : in_room.places) EXPECT_LT(place.position.norm(), 70);
}

TEST(SelfSimilarity, OfNothingIsNothing) {
  EXPECT_TRUE(measureSelfSimilarity({}, Options(), 10).places.empty());
}

}  // namespace
}  // namespace xview
