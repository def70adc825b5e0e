// SPDX-License-Identifier: BSD-3-Clause
#include "search/object_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/random.h"
#include "support/label_sets.h"

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
  const auto coverage = [&](double x, double y) {
    std::vector<double> found;
    map.coverage({Eigen::Vector2d(x - o.x(), y - o.y())}, found);
    return found.at(0);
  };
  EXPECT_EQ(coverage(0, 0), 1);
  EXPECT_GT(coverage(4, 0), 0.9);
  EXPECT_GT(coverage(-4, 0), 0.9);
  EXPECT_EQ(coverage(15, 0), 0);
  EXPECT_EQ(coverage(100, 0), 0);
  EXPECT_EQ(coverage(200, 0), 1);
}

/// Drawn square by square, from points of the squares around, too.
TEST(ObjectMap, CoversTheSameWhateverWasAskedForBefore) {
  Random random(7);
  SemanticGraph graph;
  for (int i = 0; i < 300; ++i)
    addVertex(graph, kPole, random.uniform(-150, 150), random.uniform(-150, 150));
  const ObjectMap map(graph, someLabels(), {});
  std::vector<Eigen::Vector2d> places;
  for (int i = 0; i < 500; ++i)
    places.emplace_back(random.uniform(-170, 170), random.uniform(-170, 170));
  std::vector<double> at_once;
  map.coverage(places, at_once);
  const ObjectMap again(graph, someLabels(), {});
  int covered = 0, uncovered = 0;
  for (std::size_t i = places.size(); i-- > 0;) {
    std::vector<double> alone;
    again.coverage({places[i]}, alone);
    EXPECT_EQ(alone, std::vector<double>{at_once[i]});
    double nearest_m = 1e9;
    for (const MapPoint& p : map.points())
      nearest_m = std::min(nearest_m, std::hypot(p.x - places[i].x(), p.y - places[i].y()));
    if (nearest_m >= 4 && nearest_m <= 13) continue;
    EXPECT_EQ(at_once[i], nearest_m < 4 ? 1 : 0);
    ++(nearest_m < 4 ? covered : uncovered);
  }
  EXPECT_GT(covered, 10);
  EXPECT_GT(uncovered, 10);
}

TEST(ObjectMap, HasHeightsIfTheyDiffer) {
  SemanticGraph graph;
  addVertex(graph, kPole, 0, 0, 7);
  addVertex(graph, kPole, 20, 0, 7);
  EXPECT_FALSE(ObjectMap(graph, someLabels(), {}).hasHeights());
  addVertex(graph, kPole, 40, 0, 8);
  EXPECT_TRUE(ObjectMap(graph, someLabels(), {}).hasHeights());
  EXPECT_FALSE(ObjectMap(SemanticGraph(), someLabels(), {}).hasHeights());
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
