// SPDX-License-Identifier: BSD-3-Clause
#include "io/graph_files.h"

#include <gtest/gtest.h>

#include "base/random.h"
#include "small_files.h"
#include "support/test_data.h"
#include "xview/base/error.h"

namespace xview::io {
namespace {

using test::messageOf;

SemanticGraph randomGraph(std::size_t vertices) {
  SemanticGraph graph;
  Random random(11);
  for (std::size_t i = 0; i < vertices; ++i) {
    Vertex vertex;
    vertex.label = random.below(30);
    vertex.instance = random.below(4000000000u);
    vertex.position = {random.normal() * 1e6, random.normal() / 3, random.normal() * 1e-9};
    vertex.extent = {random.uniform(), random.uniform(), 1.0 / 3.0};
    vertex.sigma_m = random.uniform();
    vertex.observations = random.below(100);
    vertex.points = random.below(100000);
    vertex.first_frame = static_cast<std::int64_t>(random.below(1000)) - 10;
    vertex.last_frame = std::int64_t{1} << 40;
    graph.vertices.push_back(vertex);
  }
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (std::size_t i = 0; i < 3 * vertices; ++i) {
    edges.emplace_back(random.below(static_cast<std::uint32_t>(vertices)),
                       random.below(static_cast<std::uint32_t>(vertices)));
  }
  graph.setEdges(edges);
  return graph;
}

void expectSame(const SemanticGraph& a, const SemanticGraph& b) {
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(a.neighbours, b.neighbours);
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Vertex &v = a.vertices[i], &w = b.vertices[i];
    EXPECT_EQ(v.label, w.label);
    EXPECT_EQ(v.instance, w.instance);
    EXPECT_EQ(v.position, w.position);
    EXPECT_EQ(v.extent, w.extent);
    EXPECT_EQ(v.sigma_m, w.sigma_m);
    EXPECT_EQ(v.observations, w.observations);
    EXPECT_EQ(v.points, w.points);
    EXPECT_EQ(v.first_frame, w.first_frame);
    EXPECT_EQ(v.last_frame, w.last_frame);
  }
}

class GraphFiles : public ::testing::Test {
 protected:
  GraphFile read(const std::string& bytes) const {
    test::writeText(path_, bytes);
    return readGraph(path_);
  }
  /// What is said about the file, without its path.
  std::string complaint(const std::string& bytes) const {
    test::writeText(path_, bytes);
    const std::string error = messageOf<Error>([&] { readGraph(path_); });
    return error.rfind(path_, 0) == 0 ? error.substr(path_.size()) : error;
  }

  test::TemporaryFolder folder_;
  const std::string path_ = folder_ / "graph.ply";
};

const std::string kThreeVertices =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty "
    "double z\n"
    "property int label\n";
const std::string kEdges =
    "element edge 2\nproperty int vertex1\nproperty int vertex2\nend_header\n";

TEST_F(GraphFiles, WhatIsWrittenReadsBackExactly) {
  const SemanticGraph graph = randomGraph(200);
  writeGraph(path_, graph, genericLabelSet({1, 2, 3}));
  const GraphFile file = readGraph(path_);
  EXPECT_TRUE(file.has_edges);
  EXPECT_TRUE(isConsistent(file.graph));
  expectSame(file.graph, graph);
}

TEST_F(GraphFiles, RememberTheirClasses) {
  LabelSet labels("town");
  ClassInfo info;
  info.id = 2;
  info.name = "street lamp";
  info.kind = Kind::light;
  labels.add(info);
  writeGraph(path_, randomGraph(5), labels);
  const std::optional<LabelSet> read = readGraph(path_).labels;
  ASSERT_TRUE(read);
  EXPECT_EQ(*read, labels);
  EXPECT_EQ(read->kind(2), Kind::light);
}

/// Check fix for: names with a carriage return were others once they had been written.
TEST_F(GraphFiles, NamesOfClassesHaveNoLineEnds) {
  LabelSet labels("town");
  ClassInfo info;
  info.id = 2;
  info.name = "street lamp";
  labels.add(info);
  writeGraph(path_, randomGraph(5), labels);
  std::string text = test::readText(path_);
  text.insert(text.find("lamp"), "\r ");
  test::writeText(path_, text);
  EXPECT_EQ(readGraph(path_).labels, labels);
}

TEST_F(GraphFiles, RememberThatEdgesWereFoundInImages) {
  SemanticGraph graph = randomGraph(5);
  writeGraph(path_, graph, LabelSet());
  EXPECT_EQ(readGraph(path_).graph.space, GraphSpace::cloud);
  graph.space = GraphSpace::image;
  writeGraph(path_, graph, LabelSet());
  EXPECT_EQ(readGraph(path_).graph.space, GraphSpace::image);
  expectSame(readGraph(path_).graph, graph);
}

TEST_F(GraphFiles, LabelsBeyondTheSignedRangeSurvive) {
  SemanticGraph graph = randomGraph(2);
  graph.vertices[1].label = 4000000000u;
  writeGraph(path_, graph, LabelSet());
  expectSame(readGraph(path_).graph, graph);
}

TEST_F(GraphFiles, AnEmptyGraphAndAGraphWithoutEdgesAreValidFiles) {
  writeGraph(path_, SemanticGraph(), LabelSet());
  EXPECT_TRUE(readGraph(path_).graph.empty());
  SemanticGraph lonely = randomGraph(2);
  lonely.setEdges({});
  writeGraph(path_, lonely, LabelSet());
  EXPECT_TRUE(readGraph(path_).has_edges) << "no edges is what the writer wanted";
  expectSame(readGraph(path_).graph, lonely);
}

TEST_F(GraphFiles, HaveNoEdgesIfTheElementIsMissing) {
  const GraphFile file =
      read(kThreeVertices + "end_header\n500000.123456789 2 3 7\n1 2 3 -1\n0 0 0 80\n");
  EXPECT_FALSE(file.has_edges);
  ASSERT_EQ(file.graph.size(), 3u);
  EXPECT_TRUE(isConsistent(file.graph));
  EXPECT_EQ(file.graph.edgeCount(), 0u);
  EXPECT_EQ(file.graph.vertices[0].position.x(), 500000.123456789);
  EXPECT_EQ(file.graph.vertices[0].observations, 1u);
  EXPECT_EQ(file.graph.vertices[1].label, 0u);
}

TEST_F(GraphFiles, EdgesMayComeFirstTwiceAndInBothDirections) {
  const GraphFile file = read(
      "ply\nformat ascii 1.0\nelement edge 3\nproperty uchar vertex1\nproperty float vertex2\n"
      "element vertex 2\nproperty float x\nproperty float y\nproperty float z\nproperty float "
      "label\n"
      "end_header\n0 1\n1 0\n1 1\n0 0 0 7\n1 1 1 8\n");
  EXPECT_TRUE(file.has_edges);
  EXPECT_EQ(file.graph.edges(), (std::vector<std::pair<std::uint32_t, std::uint32_t>>{{0, 1}}));
}

TEST_F(GraphFiles, EdgesToNowhereAreErrorsWithTheLine) {
  const std::string vertices = "1 1 1 1\n2 2 2 2\n3 3 3 3\n";
  const std::string what = ": an edge must join vertices 0 to 3 (excluded)";
  EXPECT_EQ(complaint(kThreeVertices + kEdges + vertices + "0 1\n1 3\n"), ":16" + what);
  EXPECT_EQ(complaint(kThreeVertices + kEdges + vertices + "0 1\n-1 2\n"), ":16" + what);
  EXPECT_EQ(complaint(kThreeVertices + kEdges + vertices + "0 1\n"),
            ":15: the file ends after 1 of 2 rows of 'edge'");
}

TEST_F(GraphFiles, VerticesWithoutAPlaceOrWithANonsenseSizeAreErrors) {
  EXPECT_EQ(complaint(kThreeVertices + "end_header\n1 2 3 4\nnan 2 3 4\n1 2 3 4\n"),
            ":10: the position is not finite");
  EXPECT_EQ(complaint(kThreeVertices + "end_header\n1 2 3 4\n1e300 2 3 4\n1 2 3 4\n"),
            ":10: a coordinate beyond 1e12 m");
  EXPECT_EQ(complaint(kThreeVertices +
                      "property float sigma\nend_header\n1 2 3 4 0\n1 2 3 4 -1\n1 2 3 4 0\n"),
            ":11: 'sigma' must be finite and >= 0");
  EXPECT_EQ(complaint(kThreeVertices + "end_header\n1 2 3 4\n1 2 3 4.5\n1 2 3 4\n"),
            ":10: the value of 'label' is not a whole number");
}

TEST_F(GraphFiles, ALabelIsRequired) {
  EXPECT_EQ(
      complaint("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
                "property float z\nend_header\n1 2 3\n"),
      ": has no label field; its fields: x y z");
  EXPECT_EQ(complaint("ply\nformat ascii 1.0\nend_header\n"), ": has no element vertex");
}

TEST_F(GraphFiles, ColorsAreThoseOfTheLabels) {
  SemanticGraph graph = randomGraph(1);
  graph.vertices[0].label = 7;
  LabelSet labels("test");
  ClassInfo info;
  info.id = 7;
  info.color = {250, 128, 3};
  labels.add(info);
  writeGraph(path_, graph, labels);
  EXPECT_NE(test::readText(path_).find(" 250 128 3 7 "), std::string::npos);
}

TEST_F(GraphFiles, AFullDiskIsAnError) {
  EXPECT_NE(messageOf<Error>([&] { writeGraph("/dev/full", randomGraph(3), LabelSet()); }), "");
}

TEST(RecordedGraphs, LoadWithAllDigitsAndInstances) {
  XVIEW_REQUIRE_DATA(data, "");
  const GraphFile andorra = readGraph(data + "osm/andorra_2021-10-28.ply");
  EXPECT_FALSE(andorra.has_edges);
  EXPECT_EQ(andorra.graph.size(), 8740u);
  EXPECT_EQ(andorra.graph.vertices[6].position, Eigen::Vector3d(-4615.36, 12582.96, 0));
  EXPECT_EQ(andorra.graph.vertices[6].label, 16u);
  EXPECT_EQ(andorra.graph.vertices[6].instance, 45160922u);
  EXPECT_EQ(readGraph(data + "osm/andorra_2020-05-01.ply").graph.size(), 7492u);
  EXPECT_EQ(readGraph(data + "osm/monaco_2012-07-06.ply").graph.size(), 1683u);
  EXPECT_EQ(readGraph(data + "osm/monaco_2020-07-19.ply").graph.size(), 3288u);
  const GraphFile poles = readGraph(data + "pole_maps/poles_nclt_gt.ply");
  EXPECT_EQ(poles.graph.size(), 1205u);
  EXPECT_EQ(poles.graph.vertices[1].position, Eigen::Vector3d(-1.763, -7.443, 0));
  EXPECT_EQ(readGraph(data + "pole_maps/poles_nclt_auto.ply").graph.size(), 1635u);
}

}  // namespace
}  // namespace xview::io
