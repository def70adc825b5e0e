// SPDX-License-Identifier: BSD-3-Clause
#include "../../src/match/object_verifier.h"

#include <gtest/gtest.h>

#include "support/label_sets.h"
#include "xview/match/object_places.h"

namespace xview {
namespace {

enum Id : std::uint32_t { kPole = 1, kWall };

LabelSet someLabels() {
  return test::labelSetOf("test", {{kPole, "pole", Role::object, Kind::pole},
                                   {kWall, "wall", Role::surface, Kind::building}});
}

void addVertex(SemanticGraph& graph, std::uint32_t label, double x, double y) {
  Vertex v;
  v.label = label;
  v.position = {x, y, 0};
  graph.vertices.push_back(v);
  graph.neighbours.emplace_back();
}

SemanticGraph poles() {
  SemanticGraph graph;
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 5; ++j) addVertex(graph, kPole, 30 * i, 30 * j);
  }
  return graph;
}

/// Score of the true pose of a query of all poles and of a sample of a wall that is not in the map.
double scoreWithWallAt(double x, double y) {
  SemanticGraph map = poles();
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < 4; ++k) addVertex(map, kWall, 30 * i + 10 + 3 * k, 15);
  }
  SemanticGraph query = poles();
  addVertex(query, kWall, x, y);
  return ObjectPlaceIndex(map, someLabels())
      .score(query, {Eigen::Isometry3d::Identity()})
      .at(0)
      .score;
}

TEST(ObjectVerifier, AWholeWallThatIsMissingSpeaksMoreAgainstAPoseThanAGapInWhatIsThere) {
  const double on_a_wall = scoreWithWallAt(43, 15), beside_a_pole = scoreWithWallAt(34, 62),
               on_its_own = scoreWithWallAt(45, 75);
  EXPECT_LT(beside_a_pole, on_a_wall);
  EXPECT_LT(on_its_own, beside_a_pole);
}

}  // namespace
}  // namespace xview
