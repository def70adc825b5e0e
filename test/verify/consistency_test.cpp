// SPDX-License-Identifier: BSD-3-Clause
#include "xview/verify/consistency.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "xview/types/pose.h"
#include "xview/types/random.h"

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
          std::abs(dq - dm) <= options.tolerance_m + kRelativeTolerance * std::max(dq, dm);
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
  const Clique clique = maximumClique(graph);
  int right = 0;
  for (const std::uint32_t node : clique.nodes) right += node >= 1000 ? 1 : 0;
  EXPECT_GE(right, 14);
}

TEST(PairwiseConsistency, UsesOnlyTheMostSimilarBeyondTheLimit) {
  const Points query = randomPoints(60, 60, 1);
  std::vector<Correspondence> truth;
  for (std::uint32_t i = 0; i < 60; ++i) truth.push_back({i, i, i % 2 == 0 ? 0.9f : 0.1f});
  const auto graph = pairwiseConsistency(query, query, truth, {}, 30);
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

constexpr int kPlenty = 1000000;

ConsistencyGraph randomGraph(std::uint32_t nodes, double density, std::uint64_t seed) {
  Random random(seed);
  ConsistencyGraph graph(nodes);
  for (std::uint32_t a = 0; a < nodes; ++a) {
    for (std::uint32_t b = 0; b < a; ++b) {
      if (random.uniform() < density) graph.connect(a, b);
    }
  }
  return graph;
}

bool isClique(const ConsistencyGraph& graph, const std::vector<std::uint32_t>& nodes) {
  for (const std::uint32_t a : nodes) {
    for (const std::uint32_t b : nodes) {
      if (a != b && !graph.connected(a, b)) return false;
    }
  }
  return true;
}

std::vector<std::uint32_t> subset(std::uint32_t bits) {
  std::vector<std::uint32_t> nodes;
  for (std::uint32_t i = 0; i < 32; ++i) {
    if (bits >> i & 1) nodes.push_back(i);
  }
  return nodes;
}

std::size_t cliqueNumberByEnumeration(const ConsistencyGraph& graph) {
  std::size_t best = 0;
  for (std::uint32_t bits = 0; bits < 1u << graph.size(); ++bits) {
    const auto nodes = subset(bits);
    if (nodes.size() > best && isClique(graph, nodes)) best = nodes.size();
  }
  return best;
}

/// Largest k such that the node is in some set whose members have k neighbours in the set.
std::vector<std::uint32_t> coresByEnumeration(const ConsistencyGraph& graph) {
  std::vector<std::uint32_t> cores(graph.size(), 0);
  for (std::uint32_t bits = 1; bits < 1u << graph.size(); ++bits) {
    const auto nodes = subset(bits);
    std::size_t smallest = nodes.size();
    for (const std::uint32_t a : nodes) {
      const auto inside = std::count_if(nodes.begin(), nodes.end(), [&](std::uint32_t b) {
        return b != a && graph.connected(a, b);
      });
      smallest = std::min(smallest, static_cast<std::size_t>(inside));
    }
    for (const std::uint32_t a : nodes) {
      cores[a] = std::max(cores[a], static_cast<std::uint32_t>(smallest));
    }
  }
  return cores;
}

TEST(MaximumClique, IsAsLargeAsEnumerationFinds) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    for (const double density : {0.2, 0.5, 0.8}) {
      const auto graph = randomGraph(5 + static_cast<std::uint32_t>(seed % 10), density, seed);
      const Clique clique = maximumClique(graph, kPlenty);
      EXPECT_TRUE(clique.proven_maximum);
      EXPECT_TRUE(isClique(graph, clique.nodes));
      EXPECT_TRUE(std::is_sorted(clique.nodes.begin(), clique.nodes.end()));
      EXPECT_EQ(clique.nodes.size(), cliqueNumberByEnumeration(graph));
    }
  }
}

TEST(MaximumClique, FindsAPlantedCliqueBeyondOneWordOfBits) {
  auto graph = randomGraph(300, 0.3, 5);
  std::vector<std::uint32_t> planted;
  for (std::uint32_t i = 0; i < 20; ++i) planted.push_back(3 + 14 * i);
  for (const std::uint32_t a : planted) {
    for (const std::uint32_t b : planted) {
      if (a < b) graph.connect(a, b);
    }
  }
  const Clique clique = maximumClique(graph, kPlenty);
  EXPECT_TRUE(clique.proven_maximum);
  EXPECT_EQ(clique.nodes, planted);
}

TEST(MaximumClique, OfTheComplementOfTriangles) {
  // 12 groups of 3, joined across groups only (Moon & Moser): 3^12 maximum cliques of size 12.
  ConsistencyGraph graph(36);
  for (std::uint32_t a = 0; a < 36; ++a) {
    for (std::uint32_t b = 0; b < a; ++b) {
      if (a / 3 != b / 3) graph.connect(a, b);
    }
  }
  const Clique clique = maximumClique(graph, kPlenty);
  EXPECT_TRUE(clique.proven_maximum);
  EXPECT_EQ(clique.nodes.size(), 12u);
}

TEST(MaximumClique, ThatExhaustsItsBudgetIsAValidCliqueAndSaysSo) {
  const auto graph = randomGraph(200, 0.9, 7);
  const Clique hurried = maximumClique(graph, 10);
  EXPECT_FALSE(hurried.proven_maximum);
  EXPECT_TRUE(isClique(graph, hurried.nodes));
  EXPECT_GT(hurried.nodes.size(), 20u);
}

TEST(MaximumClique, IsRepeatable) {
  const auto graph = randomGraph(150, 0.7, 9);
  for (const int budget : {1, 100, 3000}) {
    EXPECT_EQ(maximumClique(graph, budget).nodes, maximumClique(graph, budget).nodes);
  }
}

TEST(MaximumClique, Empty) {
  const Clique clique = maximumClique(ConsistencyGraph(0), kPlenty);
  EXPECT_TRUE(clique.nodes.empty());
  EXPECT_TRUE(clique.proven_maximum);
}

TEST(MaximumClique, WithoutEdgesIsOneNode) {
  const Clique clique = maximumClique(ConsistencyGraph(70), kPlenty);
  EXPECT_EQ(clique.nodes.size(), 1u);
  EXPECT_TRUE(clique.proven_maximum);
}

TEST(MaximumClique, Star) {
  ConsistencyGraph graph(100);
  for (std::uint32_t i = 1; i < 100; ++i) graph.connect(0, i);
  const Clique clique = maximumClique(graph, kPlenty);
  EXPECT_EQ(clique.nodes.size(), 2u);
  EXPECT_EQ(clique.nodes[0], 0u);
}

TEST(MaximumClique, Chain) {
  ConsistencyGraph graph(100);
  for (std::uint32_t i = 1; i < 100; ++i) graph.connect(i - 1, i);
  EXPECT_EQ(maximumClique(graph, kPlenty).nodes.size(), 2u);
}

TEST(MaximumClique, Complete) {
  ConsistencyGraph graph(130);
  for (std::uint32_t a = 0; a < 130; ++a) {
    for (std::uint32_t b = 0; b < a; ++b) graph.connect(a, b);
  }
  const Clique clique = maximumClique(graph, 1);
  EXPECT_EQ(clique.nodes.size(), 130u);
  EXPECT_TRUE(clique.proven_maximum);
}

TEST(MaximumClique, DisconnectedTakesTheLargerPart) {
  ConsistencyGraph graph(9);
  for (std::uint32_t a = 0; a < 4; ++a) {
    for (std::uint32_t b = 0; b < a; ++b) graph.connect(a, b);
  }
  for (std::uint32_t a = 4; a < 9; ++a) {
    for (std::uint32_t b = 4; b < a; ++b) graph.connect(a, b);
  }
  EXPECT_EQ(maximumClique(graph, kPlenty).nodes, (std::vector<std::uint32_t>{4, 5, 6, 7, 8}));
}

TEST(CoreNumbers, AreThoseOfEnumeration) {
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const auto graph = randomGraph(11, 0.15 + 0.06 * static_cast<double>(seed), seed);
    EXPECT_EQ(coreNumbers(graph), coresByEnumeration(graph));
  }
}

}  // namespace
}  // namespace xview::verify
