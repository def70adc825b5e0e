// SPDX-License-Identifier: BSD-3-Clause
#include "search/object_map.h"

#include <gtest/gtest.h>

#include "support/label_sets.h"
#include "xview/types/random.h"

namespace xview::search {
namespace {

enum Id : std::uint32_t { kPole = 1, kTree, kWall };

LabelSet someLabels() {
  return xview::test::labelSetOf("test", {{kPole, "pole", Role::object, Kind::pole},
                                          {kTree, "tree", Role::object, Kind::vegetation},
                                          {kWall, "wall", Role::surface, Kind::building}});
}

void addVertex(SemanticGraph& graph, std::uint32_t label, double x, double y, double z = 0) {
  Vertex v;
  v.label = label;
  v.position = {x, y, z};
  graph.vertices.push_back(v);
  graph.neighbours.emplace_back();
}

/// Walls along x of the given length, one every 40 m of y, a sample every 3 m.
SemanticGraph walls(double length_m, double gap_m) {
  SemanticGraph graph;
  for (int row = 0; row < 10; ++row) {
    for (double start = 0; start < 300; start += length_m + gap_m) {
      for (double x = start; x < std::min(300.0, start + length_m); x += 3)
        addVertex(graph, kWall, x, 40.0 * row);
    }
  }
  return graph;
}

double gainWeight(const SemanticGraph& graph) {
  return ObjectMap(graph, someLabels(), {}).classes().at(0).gain_weight;
}

TEST(ObjectMap, ASurfaceThatGoesOnSaysLessThanOneOfShortPieces) {
  EXPECT_LT(gainWeight(walls(300, 0)), 0.1);
  EXPECT_GT(gainWeight(walls(9, 60)), 0.7);
  EXPECT_LT(gainWeight(walls(40, 10)), gainWeight(walls(9, 60)));
}

TEST(ObjectMap, AnAreaSaysLessThanALine) {
  SemanticGraph area;
  for (int x = 0; x < 30; ++x) {
    for (int y = 0; y < 30; ++y) addVertex(area, kWall, 3 * x, 3 * y);
  }
  EXPECT_LT(gainWeight(area), 0.3);
  EXPECT_LT(gainWeight(area), 0.5 * gainWeight(walls(9, 60)));
}

TEST(ObjectMap, CoversWhatIsNearItsVertices) {
  SemanticGraph graph;
  addVertex(graph, kPole, 0, 0);
  addVertex(graph, kPole, 200, 0);
  const ObjectMap map(graph, someLabels(), {});
  const Eigen::Vector3d o = map.origin();
  EXPECT_EQ(map.coverage(0 - o.x(), 0 - o.y()), 1);
  EXPECT_GT(map.coverage(4 - o.x(), 0 - o.y()), 0.9);
  EXPECT_EQ(map.coverage(15 - o.x(), 0 - o.y()), 0);
  EXPECT_EQ(map.coverage(100 - o.x(), 0 - o.y()), 0);
}

TEST(ObjectMap, HasHeightsIfTheyDiffer) {
  SemanticGraph graph;
  addVertex(graph, kPole, 0, 0, 7);
  addVertex(graph, kPole, 20, 0, 7);
  EXPECT_FALSE(ObjectMap(graph, someLabels(), {}).hasHeights());
  addVertex(graph, kPole, 40, 0, 8);
  EXPECT_TRUE(ObjectMap(graph, someLabels(), {}).hasHeights());
  EXPECT_FALSE(ObjectMap({}, someLabels(), {}).hasHeights());
}

/// Walls of which any of several storeys was sampled, above level ground.
TEST(ObjectMap, HeightsOfAFacadeSaySomethingOnlyAsFarAsItsSamplesAgree) {
  Random random(5);
  const auto heightOf = [&](double storey_m) {
    SemanticGraph graph = walls(40, 20);
    for (Vertex& v : graph.vertices) v.position.z() = storey_m * random.below(4);
    return ObjectMap(graph, someLabels(), {}).classes().at(0).height_m;
  };
  EXPECT_EQ(heightOf(0), ObjectClass().height_m);
  EXPECT_GT(heightOf(3), 3);
  EXPECT_LT(heightOf(3), 10);
}

}  // namespace
}  // namespace xview::search
