// SPDX-License-Identifier: BSD-3-Clause
#include "xview/verify/consistency.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "xview/types/pose.h"
#include "xview/types/random.h"
#include "xview/verify/clique.h"

namespace xview::verify {
namespace {

using Points = std::vector<Eigen::Vector3d>;

Points randomPoints(std::size_t count, double size_m, std::uint64_t seed) {
  Random random(seed);
  Points points(count);
  for (auto& p : points) {
    p = {random.uniform(0, size_m), random.uniform(0, size_m), random.uniform(0, 5)};
  }
  return points;
}

std::vector<Correspondence> randomCorrespondences(std::size_t count, std::uint32_t query,
                                                  std::uint32_t map, std::uint64_t seed) {
  Random random(seed);
  std::vector<Correspondence> result;
  for (std::size_t i = 0; i < count; ++i) {
    result.push_back(
        {random.below(query), random.below(map), static_cast<float>(random.uniform())});
  }
  return result;
}

void expectTheDefinition(double min_separation_m) {
  const Points query = randomPoints(30, 60, 1), map = randomPoints(50, 80, 2);
  const auto correspondences = randomCorrespondences(200, 30, 50, 3);
  ConsistencyOptions options;
  options.min_separation_m = min_separation_m;
  const ConsistencyGraph graph = pairwiseConsistency(query, map, correspondences, options);
  ASSERT_EQ(graph.size(), 200u);
  for (std::uint32_t a = 0; a < 200; ++a) {
    for (std::uint32_t b = 0; b < 200; ++b) {
      const Correspondence& x = correspondences[a];
      const Correspondence& y = correspondences[b];
      const double dq = (query[x.query] - query[y.query]).norm();
      const double dm = (map[x.map] - map[y.map]).norm();
      const bool agree =
          a != b && x.query != y.query && x.map != y.map && std::min(dq, dm) >= min_separation_m &&
          std::abs(dq - dm) <= options.tolerance_m + options.relative * std::max(dq, dm);
      EXPECT_EQ(graph.connected(a, b), agree) << a << " " << b;
    }
  }
}

TEST(PairwiseConsistency, IsTheDefinitionForEveryPair) {
  expectTheDefinition(8);
  expectTheDefinition(
      0);  // then vertices that are their own partner twice are told by their number
}

TEST(PairwiseConsistency, DoesNotDependOnTheMotionBetweenQueryAndMap) {
  const Points query = randomPoints(40, 60, 1);
  Eigen::Isometry3d T = poseFromYaw({400, -300, 20}, 2.0);
  T.rotate(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitX()));
  Points map;
  for (const auto& p : query) map.push_back(T * p);
  std::vector<Correspondence> truth;
  for (std::uint32_t i = 0; i < 40; ++i) truth.push_back({i, i, 1});
  ConsistencyOptions options;
  options.min_separation_m = 0;
  const auto graph = pairwiseConsistency(query, map, truth, options);
  for (std::uint32_t i = 0; i < 40; ++i) EXPECT_EQ(graph.degree(i), 39u);
}

TEST(PairwiseConsistency, ThenCliqueRecoversTheTruthAmongManyOutliers) {
  const Points query = randomPoints(40, 60, 1);
  Points map = randomPoints(400, 400, 2);
  const Eigen::Isometry3d T = poseFromYaw({150, 100, 0}, 1.0);
  for (std::uint32_t i = 0; i < 15; ++i) map[10 * i] = T * query[i];
  auto correspondences = randomCorrespondences(1000, 40, 400, 5);
  for (std::uint32_t i = 0; i < 15; ++i) correspondences.push_back({i, 10 * i, 0.5f});
  const auto graph = pairwiseConsistency(query, map, correspondences, {});
  const Clique clique = maximumClique(graph, 200000);
  int right = 0;
  for (const std::uint32_t node : clique.nodes) right += node >= 1000 ? 1 : 0;
  EXPECT_GE(right, 14);
}

TEST(PairwiseConsistency, UsesOnlyTheMostSimilarBeyondTheLimit) {
  const Points query = randomPoints(60, 60, 1);
  std::vector<Correspondence> truth;
  for (std::uint32_t i = 0; i < 60; ++i) truth.push_back({i, i, i % 2 == 0 ? 0.9f : 0.1f});
  ConsistencyOptions options;
  options.max_correspondences = 30;
  const auto graph = pairwiseConsistency(query, query, truth, options);
  ASSERT_EQ(graph.size(), 60u);
  for (std::uint32_t i = 0; i < 60; ++i) EXPECT_EQ(graph.degree(i) > 0, i % 2 == 0) << i;
}

TEST(PairwiseConsistency, AgreesWithNothingWherePositionsAreNotFinite) {
  Points query = randomPoints(5, 60, 1);
  const Points map = query;
  query[2].y() = std::numeric_limits<double>::quiet_NaN();
  query[3].x() = std::numeric_limits<double>::infinity();
  std::vector<Correspondence> truth;
  for (std::uint32_t i = 0; i < 5; ++i) truth.push_back({i, i, 1});
  const auto graph = pairwiseConsistency(query, map, truth, {});
  EXPECT_EQ(graph.degree(2), 0u);
  EXPECT_EQ(graph.degree(3), 0u);
  EXPECT_EQ(graph.degree(0), 2u);
}

TEST(PairwiseConsistency, OfNothingIsEmpty) {
  EXPECT_EQ(pairwiseConsistency({}, {}, {}, {}).size(), 0u);
}

}  // namespace
}  // namespace xview::verify
