// SPDX-License-Identifier: BSD-3-Clause
// Bare graphs of objects as query and map.
#include <gtest/gtest.h>

#include "base/pose.h"
#include "base/random.h"
#include "place/edges.h"
#include "xview/localizer.h"
#include "xview/mapper.h"

namespace xview {

namespace {

constexpr std::uint32_t kClasses = 5;

LabelSet objectLabels() { return genericLabelSet({1, 2, 3, 4, 5}); }

SemanticGraph scatteredObjects(std::size_t count, double side_m, std::uint64_t seed) {
  SemanticGraph graph;
  Random random(seed);
  for (std::size_t i = 0; i < count; ++i) {
    Vertex v;
    v.label = 1 + random.below(kClasses);
    v.position = {random.uniform(0, side_m), random.uniform(0, side_m), 0};
    graph.vertices.push_back(v);
  }
  connectByRadius(graph, {});
  return graph;
}

SemanticGraph cutOut(const SemanticGraph& graph, const Eigen::Vector2d& centre, double radius_m) {
  SemanticGraph part;
  for (const Vertex& v : graph.vertices) {
    if ((v.position.head<2>() - centre).norm() <= radius_m) part.vertices.push_back(v);
  }
  connectByRadius(part, {});
  return part;
}

SemanticGraph moved(SemanticGraph graph, const Eigen::Isometry3d& T) {
  for (Vertex& v : graph.vertices) v.position = T * v.position;
  return graph;
}

Localization find(const SemanticGraph& query, const SemanticGraph& map_graph,
                  const std::string& method = "auto") {
  Options options;
  options.method = method;
  const map::SemanticMap map = buildMap(map_graph, objectLabels(), "objects", options);
  return Localizer(map, options).localize(makeQuery(query, objectLabels(), options));
}

TEST(GraphQuery, APartOfTheMapIsFoundWhereItWasCutOut) {
  const SemanticGraph map = scatteredObjects(600, 400, 3);
  const Eigen::Isometry3d T_query_map = poseFromYaw({-812, 55, 0}, 1.3);
  const SemanticGraph query = moved(cutOut(map, {200, 180}, 60), T_query_map);
  for (const char* method : {"auto", "walks"}) {
    const Localization fix = find(query, map, method);
    EXPECT_EQ(fix.status, Status::accepted) << method << ": " << fix.reason;
    EXPECT_LT((fix.T_map_query * T_query_map).translation().norm(), 0.5) << method;
    EXPECT_LT(rotationBetween(fix.T_map_query, T_query_map.inverse()), 0.02) << method;
  }
}

TEST(GraphQuery, AMirroredPartIsNotAccepted) {
  const SemanticGraph map = scatteredObjects(600, 400, 3);
  SemanticGraph query = cutOut(map, {200, 180}, 60);
  for (Vertex& v : query.vertices) v.position.x() = -v.position.x();
  for (const char* method : {"auto", "walks"})
    EXPECT_NE(find(query, map, method).status, Status::accepted) << method;
}

TEST(GraphQuery, AnotherWorldIsNotAccepted) {
  const SemanticGraph map = scatteredObjects(600, 400, 3);
  const SemanticGraph query = cutOut(scatteredObjects(600, 400, 4), {200, 180}, 60);
  for (const char* method : {"auto", "walks"})
    EXPECT_NE(find(query, map, method).status, Status::accepted) << method;
}

TEST(GraphQuery, InMillimetresItCannotLieInAMapInMetres) {
  const SemanticGraph map = scatteredObjects(600, 400, 3);
  SemanticGraph query = cutOut(map, {200, 180}, 60);
  scaleLengths(1000, query);
  const Localization result = find(query, map);
  EXPECT_FALSE(result.accepted());
  EXPECT_NE(result.reason.find("millimetres"), std::string::npos) << result.reason;
}

TEST(GraphQuery, ARepetitiveWorldIsAmbiguous) {
  const SemanticGraph block = scatteredObjects(40, 60, 9);
  SemanticGraph map;
  for (int copy = 0; copy < 5; ++copy) {
    for (Vertex v : block.vertices) {
      v.position.x() += 90 * copy;
      map.vertices.push_back(v);
    }
  }
  connectByRadius(map, {});
  EXPECT_EQ(find(block, map).status, Status::ambiguous) << find(block, map).reason;
  EXPECT_NE(find(block, map, "walks").status, Status::accepted);
}

TEST(GraphQuery, TheOrderOfVerticesDoesNotMatter) {
  const SemanticGraph map = scatteredObjects(400, 300, 8);
  SemanticGraph query = cutOut(map, {150, 150}, 60);
  const Localization forth = find(query, map);
  std::reverse(query.vertices.begin(), query.vertices.end());
  connectByRadius(query, {});
  const Localization back = find(query, map);
  EXPECT_EQ(forth.status, back.status);
  EXPECT_LT((forth.T_map_query.translation() - back.T_map_query.translation()).norm(), 1e-6);
}

TEST(GraphQuery, ASingleVertexIsNotAccepted) {
  const SemanticGraph map = scatteredObjects(400, 300, 8);
  SemanticGraph query;
  query.vertices.push_back(map.vertices[0]);
  connectByRadius(query, {});
  for (const char* method : {"auto", "walks"})
    EXPECT_NE(find(query, map, method).status, Status::accepted) << method;
}

}  // namespace
}  // namespace xview
