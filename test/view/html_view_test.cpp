// SPDX-License-Identifier: BSD-3-Clause
#include "xview/view/scene.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <regex>
#include <stdexcept>

#include "xview/types/pose.h"

namespace xview {
namespace {

using nlohmann::json;

json dataOf(const std::string& page) {
  const std::string begin = "<script id=\"scene\" type=\"application/json\">", end = "</script>";
  const std::size_t from = page.find(begin) + begin.size();
  return json::parse(page.substr(from, page.find(end, from) - from));
}

std::string decoded(const std::string& base64) {
  std::string bytes;
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : base64) {
    if (c == '=') break;
    const char* const letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const char* const found = std::strchr(letters, c);
    if (found == nullptr) throw std::runtime_error("not base64");
    bits = (bits << 6) | static_cast<std::uint32_t>(found - letters);
    if ((count += 6) >= 8) bytes += static_cast<char>(bits >> (count -= 8));
  }
  return bytes;
}

std::vector<float> floatsOf(const json& layer) {
  const std::string bytes = decoded(layer["positions"]);
  std::vector<float> values(bytes.size() / sizeof(float));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(float));
  return values;
}

const json& layerOf(const json& data, const std::string& name) {
  for (const json& layer : data["layers"]) {
    if (layer["name"] == name) return layer;
  }
  throw std::runtime_error("no layer " + name);
}

SemanticGraph triangle() {
  SemanticGraph graph;
  graph.vertices.resize(3);
  graph.vertices[1].position = {30, 0, 1};
  graph.vertices[2].position = {0, 40, 2};
  graph.vertices[2].label = 5;
  graph.setEdges({{0, 1}, {1, 2}, {0, 2}});
  return graph;
}

Scene sceneOf(const SemanticGraph& graph, const LabelSet& labels, const LabelledCloud& cloud) {
  Scene scene;
  scene.title = "accepted: 3 of 3";
  scene.labels = &labels;
  scene.map_graph = &graph;
  scene.map_cloud = &cloud;
  scene.map_poses = {poseFromYaw({0, 0, 0}, 0), poseFromYaw({1, 0, 0}, 0),
                     poseFromYaw({2, 0, 0}, 0)};
  SceneQuery query;
  query.graph = &graph;
  query.cloud = &cloud;
  query.kept = {{0, 0, 1}, {9, 0, 1}};
  query.putative = {{0, 0, 1}, {1, 2, 1}};
  query.poses = scene.map_poses;
  query.true_poses = scene.map_poses;
  scene.queries = {query};
  return scene;
}

LabelledCloud cloudOf(std::size_t points) {
  LabelledCloud cloud;
  cloud.points.resize(points);
  for (std::size_t i = 0; i < points; ++i) cloud.points[i].x = static_cast<float>(i % 30);
  return cloud;
}

TEST(HtmlView, LayersHaveTheNumbersOfPointsAndLines) {
  const SemanticGraph graph = triangle();
  const LabelSet labels = genericLabelSet({0, 5});
  const LabelledCloud cloud = cloudOf(100);
  const json data = dataOf(htmlView(sceneOf(graph, labels, cloud)));
  EXPECT_EQ(data["title"], "accepted: 3 of 3");
  EXPECT_EQ(layerOf(data, "map cloud")["count"], 100);
  EXPECT_EQ(layerOf(data, "map vertices")["count"], 3);
  EXPECT_EQ(layerOf(data, "map edges")["count"], 6);
  EXPECT_EQ(layerOf(data, "query vertices")["count"], 3);
  EXPECT_EQ(layerOf(data, "query kept matches")["count"], 2);
  EXPECT_EQ(layerOf(data, "query putative matches")["count"], 4);
  EXPECT_EQ(layerOf(data, "key frames")["count"], 4);
  for (const json& layer : data["layers"]) {
    EXPECT_EQ(floatsOf(layer).size(), 3 * layer["count"].get<std::size_t>());
    EXPECT_EQ(decoded(layer["colors"]).size(), 3 * layer["count"].get<std::size_t>());
  }
}

TEST(HtmlView, PositionsAreRelativeToTheCenter) {
  SemanticGraph graph = triangle();
  for (Vertex& v : graph.vertices) v.position += Eigen::Vector3d(500000, 4649776, 0);
  Scene scene;
  scene.map_graph = &graph;
  const json data = dataOf(htmlView(scene));
  const std::vector<float> positions = floatsOf(layerOf(data, "map vertices"));
  EXPECT_FLOAT_EQ(positions[3], 15);
  EXPECT_FLOAT_EQ(positions[7], 20);
  EXPECT_DOUBLE_EQ(data["center"][0], 500015);
}

TEST(HtmlView, CloudIsThinnedToTheLimit) {
  const SemanticGraph graph;
  const LabelSet labels;
  const LabelledCloud cloud = cloudOf(10000);
  HtmlViewOptions options;
  options.most_points = 1000;
  const json data = dataOf(htmlView(sceneOf(graph, labels, cloud), options));
  EXPECT_LE(layerOf(data, "map cloud")["count"], 1000);
  EXPECT_GE(layerOf(data, "map cloud")["count"], 500);
}

TEST(HtmlView, NeedsNothingFromOutside) {
  const SemanticGraph graph = triangle();
  const LabelSet labels = genericLabelSet({0, 5});
  const LabelledCloud cloud = cloudOf(10);
  const std::string page = htmlView(sceneOf(graph, labels, cloud));
  EXPECT_FALSE(std::regex_search(
      page, std::regex(R"((src|href)\s*=|https?://|@import|fetch\(|XMLHttpRequest)")));
}

TEST(HtmlView, ElementsAreClosed) {
  const std::string page = htmlView({});
  for (const char* name :
       {"html", "head", "body", "style", "script", "aside", "canvas", "h1", "title"}) {
    const auto count = [&](const std::string& pattern) {
      const std::regex tag(pattern);
      return std::distance(std::sregex_iterator(page.begin(), page.end(), tag),
                           std::sregex_iterator());
    };
    EXPECT_GE(count("<" + std::string(name) + "[ >]"), 1) << name;
    EXPECT_EQ(count("<" + std::string(name) + "[ >]"), count("</" + std::string(name) + ">"))
        << name;
  }
  EXPECT_EQ(page.rfind("<!DOCTYPE html>", 0), 0u);
}

TEST(HtmlView, NamesCannotBreakOutOfTheData) {
  Scene scene;
  scene.title = "</script><script>alert(1)</script> \"quoted\" \xFF";
  const std::string page = htmlView(scene);
  EXPECT_EQ(page.find("alert(1)</script>"), std::string::npos);
  EXPECT_EQ(dataOf(page)["title"].get<std::string>().substr(0, 17), "</script><script>");
}

TEST(HtmlView, LinesOfOneNameAreOneLayer) {
  Scene scene;
  const Color red{255, 0, 0}, green{0, 255, 0};
  scene.lines = {{"errors", red, {{0, 0, 0}, {1, 0, 0}}},
                 {"way", red, {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}},
                 {"errors", green, {{5, 0, 0}, {6, 0, 0}}}};
  const json data = dataOf(htmlView(scene));
  ASSERT_EQ(data["layers"].size(), 2u);
  EXPECT_EQ(layerOf(data, "errors")["count"], 4);
  EXPECT_EQ(decoded(layerOf(data, "errors")["colors"]).substr(6, 3), std::string("\0\xFF\0", 3));
}

TEST(HtmlView, WhatStandsBelowIsOnThePage) {
  HtmlViewOptions options;
  options.below = "<p>two of three</p>";
  const std::string page = htmlView({}, options);
  EXPECT_NE(page.find("<main>\n<p>two of three</p></main>"), std::string::npos);
  EXPECT_EQ(htmlView({}).find("<main>"), std::string::npos);
  EXPECT_EQ(dataOf(page), dataOf(htmlView({})));
}

TEST(HtmlView, EmptySceneIsAPage) {
  const json data = dataOf(htmlView({}));
  EXPECT_TRUE(data["layers"].empty());
  EXPECT_GT(data["radius"], 0);
}

TEST(HtmlView, NumbersThatAreNotFiniteAreLeftOut) {
  SemanticGraph graph = triangle();
  graph.vertices[0].position.z() = std::numeric_limits<double>::quiet_NaN();
  Scene scene;
  scene.map_graph = &graph;
  const json data = dataOf(htmlView(scene));
  EXPECT_EQ(layerOf(data, "map vertices")["count"], 2);
  EXPECT_EQ(layerOf(data, "map edges")["count"], 2);
}

TEST(HtmlView, SameSceneGivesTheSameBytes) {
  const SemanticGraph graph = triangle();
  const LabelSet labels = genericLabelSet({0, 5});
  const LabelledCloud cloud = cloudOf(50);
  EXPECT_EQ(htmlView(sceneOf(graph, labels, cloud)), htmlView(sceneOf(graph, labels, cloud)));
}

}  // namespace
}  // namespace xview
