// SPDX-License-Identifier: BSD-3-Clause
#include "xview/base/graph.h"

#include <gtest/gtest.h>

namespace xview {
namespace {

using Edges = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

SemanticGraph graphOf(std::size_t vertices, const Edges& edges) {
  SemanticGraph graph;
  graph.vertices.resize(vertices);
  graph.setEdges(edges);
  return graph;
}

TEST(SetEdges, IgnoresOrderDuplicatesAndSelfLoops) {
  const SemanticGraph graph = graphOf(4, {{2, 1}, {1, 2}, {3, 3}, {0, 1}, {1, 2}});
  EXPECT_EQ(graph.edges(), (Edges{{0, 1}, {1, 2}}));
  EXPECT_EQ(graph.edgeCount(), 2u);
  EXPECT_TRUE(isConsistent(graph));
}

TEST(SetEdges, ReplacesWhatWasThere) {
  SemanticGraph graph = graphOf(3, {{0, 1}});
  graph.setEdges({{1, 2}});
  EXPECT_EQ(graph.edges(), (Edges{{1, 2}}));
}

TEST(IsConsistent, SeesEveryBrokenInvariant) {
  EXPECT_TRUE(isConsistent(SemanticGraph()));
  SemanticGraph graph = graphOf(3, {{0, 1}, {0, 2}});
  EXPECT_TRUE(isConsistent(graph));

  SemanticGraph short_lists = graph;
  short_lists.neighbours.pop_back();
  EXPECT_FALSE(isConsistent(short_lists));
  SemanticGraph one_way = graph;
  one_way.neighbours[1].clear();
  EXPECT_FALSE(isConsistent(one_way));
  SemanticGraph unsorted = graph;
  unsorted.neighbours[0] = {2, 1};
  EXPECT_FALSE(isConsistent(unsorted));
  SemanticGraph twice = graph;
  twice.neighbours[0] = {1, 1, 2};
  EXPECT_FALSE(isConsistent(twice));
  SemanticGraph loop = graph;
  loop.neighbours[1] = {0, 1};
  EXPECT_FALSE(isConsistent(loop));
  SemanticGraph beyond = graph;
  beyond.neighbours[2] = {0, 3};
  EXPECT_FALSE(isConsistent(beyond));
}

TEST(ComponentCount, CountsEmptyIsolatedChainAndDisconnected) {
  EXPECT_EQ(componentCount(SemanticGraph()), 0u);
  EXPECT_EQ(componentCount(graphOf(3, {})), 3u);
  EXPECT_EQ(componentCount(graphOf(4, {{0, 1}, {1, 2}, {2, 3}})), 1u);
  EXPECT_EQ(componentCount(graphOf(6, {{0, 5}, {1, 2}, {2, 3}})), 3u);
}

}  // namespace
}  // namespace xview
