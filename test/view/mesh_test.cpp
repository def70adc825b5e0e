// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <map>

#include "view/mesh_reading.h"
#include "xview/types/pose.h"
#include "xview/view/color_mesh.h"
#include "xview/view/graph_mesh.h"
#include "xview/view/match_drawing.h"

namespace xview {
namespace {

constexpr Color kRed{200, 10, 10};

/// Volume inside a closed mesh whose faces look outwards.
double volumeOf(const ColorMesh& mesh) {
  double volume = 0;
  for (const auto& t : mesh.triangles) {
    volume += mesh.vertices[t[0]].dot(mesh.vertices[t[1]].cross(mesh.vertices[t[2]])) / 6;
  }
  return volume;
}

bool isValid(const ColorMesh& mesh) {
  if (mesh.colors.size() != mesh.vertices.size()) return false;
  for (const auto& t : mesh.triangles) {
    for (const std::uint32_t i : t) {
      if (i >= mesh.vertices.size()) return false;
    }
  }
  return true;
}

SemanticGraph chain(std::size_t vertices, double step_m) {
  SemanticGraph graph;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (std::uint32_t i = 0; i < vertices; ++i) {
    Vertex v;
    v.label = i % 3;
    v.position = {i * step_m, 0, 0};
    graph.vertices.push_back(v);
    if (i > 0) edges.emplace_back(i - 1, i);
  }
  graph.setEdges(edges);
  return graph;
}

LabelSet threeClasses() {
  LabelSet labels("three");
  for (std::uint32_t id = 0; id < 3; ++id) {
    ClassInfo info;
    info.id = id;
    info.name = "class" + std::to_string(id);
    info.color = {static_cast<std::uint8_t>(80 * id), 200, static_cast<std::uint8_t>(10 + id)};
    labels.add(info);
  }
  return labels;
}

TEST(ColorMesh, OctahedronHasItsVolumeAndLooksOutwards) {
  ColorMesh mesh;
  addOctahedron(mesh, {0, 0, 0}, 2, kRed);
  EXPECT_EQ(mesh.triangles.size(), 8u);
  EXPECT_NEAR(volumeOf(mesh), 4.0 / 3 * 8, 1e-9);
}

TEST(ColorMesh, TubeRunsFromEndToEndWithItsRadius) {
  ColorMesh mesh;
  const Eigen::Vector3d from(1, 2, 3), to(4, -2, 9);
  addTube(mesh, from, to, 0.5, kRed);
  EXPECT_EQ(mesh.triangles.size(), 6u);
  const Eigen::ParametrizedLine<double, 3> axis =
      Eigen::ParametrizedLine<double, 3>::Through(from, to);
  for (const auto& p : mesh.vertices) {
    EXPECT_NEAR(axis.distance(p), 0.5, 1e-9);
    EXPECT_NEAR(std::min((p - from).norm(), (p - to).norm()), 0.5, 1e-9);
  }
}

TEST(ColorMesh, TubeOfNoLengthIsNothing) {
  ColorMesh mesh;
  addTube(mesh, {1, 1, 1}, {1, 1, 1}, 0.5, kRed);
  EXPECT_TRUE(mesh.vertices.empty());
}

TEST(ColorMesh, VtkAndPlyReadBackTheSameMesh) {
  const ColorMesh mesh = graphMesh(chain(5, 12.3456), threeClasses());
  for (const ColorMesh& read : {test::readVtk(toVtk(mesh)), test::readPly(toPly(mesh))}) {
    ASSERT_EQ(read.vertices.size(), mesh.vertices.size());
    EXPECT_EQ(read.triangles, mesh.triangles);
    EXPECT_EQ(read.colors, mesh.colors);
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      EXPECT_LT((read.vertices[i] - mesh.vertices[i]).lpNorm<Eigen::Infinity>(), 0.00051);
    }
  }
}

TEST(ColorMesh, CoordinatesFarFromTheOriginKeepTheirMillimetres) {
  ColorMesh mesh;
  addOctahedron(mesh, {500000.125, 4649776.225, 12}, 0.5, kRed);
  EXPECT_EQ(test::readVtk(toVtk(mesh)).vertices[0], Eigen::Vector3d(500000.625, 4649776.225, 12));
}

TEST(ColorMesh, EmptyMeshIsAFile) {
  EXPECT_TRUE(test::readVtk(toVtk({})).vertices.empty());
  EXPECT_TRUE(test::readPly(toPly({})).vertices.empty());
}

TEST(GraphMesh, HasAnOctahedronPerVertexAndATubePerEdge) {
  const ColorMesh mesh = graphMesh(chain(7, 10), threeClasses());
  EXPECT_TRUE(isValid(mesh));
  EXPECT_EQ(mesh.triangles.size(), 7u * 8 + 6u * 6);
  EXPECT_EQ(mesh.vertices.size(), 7u * 6 + 6u * 6);
}

TEST(GraphMesh, VerticesHaveTheColorOfTheirClass) {
  const LabelSet labels = threeClasses();
  const ColorMesh mesh = graphMesh(chain(3, 10), labels);
  for (std::uint32_t i = 0; i < 3; ++i) EXPECT_EQ(mesh.colors[6 * i], labels.color(i));
}

TEST(GraphMesh, MovesWithItsTransform) {
  const Eigen::Isometry3d T = poseFromYaw({5, 6, 7}, 1.2);
  SemanticGraph graph = chain(4, 10);
  const ColorMesh moved = graphMesh(graph, threeClasses(), {}, T);
  EXPECT_TRUE(
      ((moved.vertices[6] + moved.vertices[7]) / 2).isApprox(T * graph.vertices[1].position));
}

TEST(GraphMesh, VertexSizeFollowsTheEdgesWithinLimits) {
  EXPECT_LT(typicalVertexRadius(chain(5, 8)), typicalVertexRadius(chain(5, 20)));
  EXPECT_GE(typicalVertexRadius(chain(5, 0.01)), 0.1);
  EXPECT_LE(typicalVertexRadius(chain(5, 1e5)), 3);
  EXPECT_GT(typicalVertexRadius(SemanticGraph()), 0);
}

TEST(GraphMesh, VerticesThatAreNotFiniteAreLeftOut) {
  SemanticGraph graph = chain(3, 10);
  graph.vertices[1].position.x() = std::numeric_limits<double>::quiet_NaN();
  const ColorMesh mesh = graphMesh(graph, threeClasses());
  EXPECT_EQ(mesh.triangles.size(), 2u * 8);
  EXPECT_EQ(toVtk(mesh).find("nan"), std::string::npos);
}

TEST(GraphMesh, DenseGraphShowsOnlyItsShortestEdges) {
  SemanticGraph graph = chain(60, 10);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> all;
  for (std::uint32_t i = 0; i < 60; ++i) {
    for (std::uint32_t j = 0; j < i; ++j) all.emplace_back(i, j);
  }
  graph.setEdges(all);
  const std::size_t tubes = (graphMesh(graph, threeClasses()).triangles.size() - 60 * 8) / 6;
  EXPECT_GE(tubes, 59u);
  EXPECT_LE(tubes, 3u * 60);
}

TEST(GraphMesh, EmptyGraphIsAnEmptyMesh) { EXPECT_TRUE(graphMesh({}, {}).vertices.empty()); }

std::size_t verticesOfColor(const ColorMesh& mesh, const Color& color) {
  return static_cast<std::size_t>(std::count(mesh.colors.begin(), mesh.colors.end(), color));
}

TEST(MatchDrawing, DrawsEachMatchOnceInItsColor) {
  const SemanticGraph map = chain(10, 10), query = chain(4, 10);
  MatchDrawingStyle style;
  const std::vector<Correspondence> putative{{0, 5, 1}, {1, 6, 1}, {2, 0, 1}},
      kept{{0, 5, 1}, {1, 6, 1}};
  const ColorMesh mesh =
      drawMatches(map, query, threeClasses(), poseFromYaw({50, 0, 0}, 0), putative, kept, style);
  EXPECT_TRUE(isValid(mesh));
  EXPECT_EQ(verticesOfColor(mesh, style.kept_color), 2u * 6);
  EXPECT_EQ(verticesOfColor(mesh, style.putative_color), 1u * 6);
}

TEST(MatchDrawing, QueryHangsAboveItsPlace) {
  const SemanticGraph map = chain(1, 10), query = chain(1, 10);
  MatchDrawingStyle style;
  style.lift_m = 33;
  const ColorMesh mesh =
      drawMatches(map, query, threeClasses(), poseFromYaw({50, 1, 2}, 0), {}, {}, style);
  ASSERT_EQ(mesh.vertices.size(), 12u);
  EXPECT_TRUE(((mesh.vertices[6] + mesh.vertices[7]) / 2).isApprox(Eigen::Vector3d(50, 1, 35)));
}

TEST(MatchDrawing, ReachLimitsTheMapToTheSurroundings) {
  const SemanticGraph map = chain(1000, 10), query = chain(3, 10);
  MatchDrawingStyle style;
  style.reach_m = 50;
  const ColorMesh near = drawMatches(map, query, threeClasses(), poseFromYaw({5000, 0, 0}, 0), {},
                                     {{0, 900, 1}}, style);
  EXPECT_EQ(near.triangles.size(),
            (13u + 1) * 8 + 12 * 6 + 3 * 8 + 2 * 6 + 6);  // 45 m … 5070 m, and the matched one
}

TEST(MatchDrawing, IndicesOutOfRangeAndEmptyGraphsAreFine) {
  const ColorMesh mesh =
      drawMatches({}, {}, {}, Eigen::Isometry3d::Identity(), {{0, 0, 1}}, {{7, 7, 1}});
  EXPECT_TRUE(mesh.vertices.empty());
}

}  // namespace
}  // namespace xview
