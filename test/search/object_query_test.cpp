// SPDX-License-Identifier: BSD-3-Clause
#include "search/object_query.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace xview::search {
namespace {

constexpr std::uint32_t kWall = 1, kHedge = 2, kPole = 3;

bool isSurface(std::uint32_t label) { return label != kPole; }

void add(SemanticGraph& graph, std::uint32_t label, double x, double z, std::uint32_t points) {
  Vertex v;
  v.label = label;
  v.position = {x, 0, z};
  v.points = points;
  graph.vertices.push_back(v);
}

std::vector<std::uint32_t> all(const SemanticGraph& graph) {
  std::vector<std::uint32_t> indices(graph.vertices.size());
  std::iota(indices.begin(), indices.end(), 0u);
  return indices;
}

std::vector<std::uint32_t> distinct(const SemanticGraph& graph) {
  return distinctFromAbove(graph, all(graph), isSurface);
}

TEST(ObjectThinning, StoreysOfAFacadeAreOneLine) {
  SemanticGraph graph;
  for (std::uint32_t storey = 0; storey < 3; ++storey) {
    for (int k = 0; k < 5; ++k) add(graph, kWall, 3 * k + 0.2 * storey, 3 * storey, 10 + storey);
  }
  EXPECT_EQ(distinct(graph), (std::vector<std::uint32_t>{10, 11, 12, 13, 14}));
}

TEST(ObjectThinning, SamplesAtTheirUsualSpacingAllStay) {
  SemanticGraph graph;
  for (int k = 0; k < 50; ++k) add(graph, kWall, 3 * k, 0, 0);
  EXPECT_EQ(distinct(graph), all(graph));
  EXPECT_EQ(wellSeen(graph, all(graph), isSurface), all(graph));
}

TEST(ObjectThinning, ThingsAreNeverLeftOut) {
  SemanticGraph graph;
  for (int k = 0; k < 4; ++k) add(graph, kPole, 0.5 * k, 0, static_cast<std::uint32_t>(k));
  add(graph, kWall, 0, 0, 1000);
  EXPECT_EQ(distinct(graph), all(graph));
  EXPECT_EQ(wellSeen(graph, all(graph), isSurface), all(graph));
}

TEST(ObjectThinning, AWallThatWasTakenForAHedgeNowAndThenIsAWall) {
  SemanticGraph graph;
  add(graph, kWall, 0, 0, 100);
  add(graph, kHedge, 1, 0, 10);   // a wrong label
  add(graph, kHedge, 1, 4, 10);   // above it, where the wall has no such sample
  add(graph, kHedge, -2, 0, 60);  // seen too well for a wrong label
  EXPECT_EQ(distinct(graph), (std::vector<std::uint32_t>{0, 2, 3}));
}

TEST(ObjectThinning, OrderOfTheVerticesDoesNotMatterWherePointsDiffer) {
  SemanticGraph graph, reversed;
  for (int k = 0; k < 40; ++k) add(graph, k % 3 == 0 ? kHedge : kWall, 0.7 * k, 0, 1 + k * 37 % 41);
  reversed.vertices.assign(graph.vertices.rbegin(), graph.vertices.rend());
  std::vector<std::uint32_t> back;
  for (const std::uint32_t i : distinct(reversed)) back.push_back(39 - i);
  std::sort(back.begin(), back.end());
  EXPECT_EQ(distinct(graph), back);
}

TEST(ObjectThinning, TheWorseSeenHalfOfASurfaceIsLeftOut) {
  SemanticGraph graph;
  for (std::uint32_t k = 0; k < 9; ++k) add(graph, kWall, 3.0 * k, 0, 10 * k);
  add(graph, kHedge, 50, 0, 3);
  EXPECT_EQ(wellSeen(graph, all(graph), isSurface), (std::vector<std::uint32_t>{4, 5, 6, 7, 8, 9}));
}

TEST(ObjectThinning, NothingComesOfNothing) {
  EXPECT_TRUE(distinct({}).empty());
  EXPECT_TRUE(wellSeen({}, {}, isSurface).empty());
}

}  // namespace
}  // namespace xview::search
