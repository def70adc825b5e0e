// SPDX-License-Identifier: BSD-3-Clause
#include "xview/alikeness.h"

#include <gtest/gtest.h>

#include "pipeline/two_streets.h"

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

const Alikeness& measured() {
  static const Alikeness alikeness = [] {
    Options options;
    options.threads = 2;
    return measureAlikeness(copiedStreets(), options, 16);
  }();
  return alikeness;
}

TEST(Alikeness, TellsCopiesFromWhatIsThereOnce) {
  int copies = 0, singles = 0;
  for (const SelfQuery& q : measured().queries) {
    const Eigen::Vector3d& p = measured().places[q.place].position;
    if (q.window_m > 30 || std::abs(p.x()) < 75) continue;  // what they see ends before x = 0
    EXPECT_EQ(q.sure, p.x() < 0) << p.transpose() << ", " << q.window_m << " m";
    if (p.x() < 0) {
      ++singles;
      continue;
    }
    ++copies;
    ASSERT_TRUE(q.rival);
    EXPECT_LT((*q.rival - Eigen::Vector3d(p.x(), 200 - p.y(), q.rival->z())).norm(), 3);
    EXPECT_GT(q.wrong, 0.7 * q.self);
  }
  EXPECT_GT(copies, 8);
  EXPECT_GT(singles, 8);
}

TEST(Alikeness, PlacesKnowWhenTheyAreSure) {
  for (const Alikeness::Place& place : measured().places) {
    if (place.position.x() < -75) {
      EXPECT_TRUE(place.sure_m) << place.position.transpose();
      EXPECT_FALSE(place.sure_m && *place.sure_m > 30 && !place.rival);
    }
  }
}

TEST(Alikeness, IsTheSameForAnyNumberOfThreads) {
  Options options;
  options.threads = 1;
  const Alikeness again = measureAlikeness(copiedStreets(), options, 16);
  ASSERT_EQ(again.queries.size(), measured().queries.size());
  for (std::size_t i = 0; i < again.queries.size(); ++i) {
    EXPECT_EQ(again.queries[i].self, measured().queries[i].self);
    EXPECT_EQ(again.queries[i].wrong, measured().queries[i].wrong);
  }
}

TEST(Alikeness, WrongScoresAreQuantilesByLength) {
  Alikeness alikeness;
  alikeness.lengths_m = {8, 15};
  for (int i = 1; i <= 101; ++i) {
    SelfQuery query;
    query.window_m = 8;
    query.self = 1000;
    query.wrong = i;
    query.next_wrong = 1;
    alikeness.queries.push_back(query);
  }
  const std::vector<WrongScores> scores = wrongScores(alikeness);
  ASSERT_EQ(scores.size(), 1u);  // nothing is known of 15 m
  EXPECT_EQ(scores[0].queries, 101u);
  EXPECT_DOUBLE_EQ(scores[0].share[0], 0.051);
  EXPECT_DOUBLE_EQ(scores[0].share[3], 0.101);
  EXPECT_DOUBLE_EQ(scores[0].lead[3], 100 * std::log(101.0));
}

TEST(Alikeness, OfNothingIsNothing) {
  EXPECT_TRUE(measureAlikeness({}, Options(), 10).places.empty());
}

}  // namespace
}  // namespace xview
