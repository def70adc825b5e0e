// SPDX-License-Identifier: BSD-3-Clause
#include "xview/verify/clique.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "xview/types/random.h"

namespace xview::verify {
namespace {

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

TEST(DensestCore, IsTheHighestCore) {
  // A complete graph of 5 with a long tail.
  ConsistencyGraph graph(20);
  for (std::uint32_t a = 10; a < 15; ++a) {
    for (std::uint32_t b = 10; b < a; ++b) graph.connect(a, b);
  }
  for (std::uint32_t i = 1; i < 11; ++i) graph.connect(i - 1, i);
  EXPECT_EQ(densestCore(graph), (std::vector<std::uint32_t>{10, 11, 12, 13, 14}));
  EXPECT_TRUE(densestCore(ConsistencyGraph(0)).empty());
  EXPECT_EQ(densestCore(ConsistencyGraph(3)).size(), 3u);
}

}  // namespace
}  // namespace xview::verify
