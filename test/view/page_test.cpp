// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <regex>
#include <stdexcept>

#include "base/pose.h"
#include "support/test_data.h"
#include "view/scene.h"

namespace xview {
namespace {

using nlohmann::json;

json dataOf(const std::string& page) {
  const std::string begin = "<script id=\"scene\" type=\"application/json\">", end = "</script>";
  const std::size_t from = page.find(begin) + begin.size();
  return json::parse(page.substr(from, page.find(end, from) - from));
}

template <class T>
std::vector<T> decoded(const std::string& base64) {
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
  std::vector<T> values(bytes.size() / sizeof(T));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  return values;
}

SemanticGraph triangle() {
  SemanticGraph graph;
  graph.vertices.resize(3);
  graph.vertices[1].position = {30, 0, 1};
  graph.vertices[2].position = {0, 40, 2};
  graph.vertices[2].label = 5;
  graph.vertices[2].sigma_m = 0.25;
  graph.setEdges({{0, 1}, {1, 2}, {0, 2}});
  return graph;
}

LabelledCloud cloudOf(std::size_t points) {
  LabelledCloud cloud;
  cloud.points.resize(points);
  for (std::size_t i = 0; i < points; ++i) {
    cloud.points[i] = Point(static_cast<float>(i % 31), static_cast<float>(i % 17), 1, 5);
  }
  return cloud;
}

/// A map, a query in it, and everything that lives as long as they are drawn.
struct PageWorld {
  SemanticGraph graph = triangle();
  LabelSet labels = genericLabelSet({0, 5});
  LabelledCloud cloud;
  Scene scene;

  explicit PageWorld(std::size_t points = 100) : cloud(cloudOf(points)) {
    scene.title = "accepted, ±2 cm";
    scene.labels = &labels;
    scene.map_graph = &graph;
    scene.map_cloud = &cloud;
    scene.map_poses = {poseFromYaw({0, 0, 0}, 0), poseFromYaw({1, 0, 0}, 0)};
    SceneQuery query;
    query.name = "rear 0-9";
    query.graph = &graph;
    query.cloud = &cloud;
    query.kept = {{0, 0, 1}, {9, 0, 1}};
    query.putative = {{0, 0, 1}, {1, 2, 1}};
    query.poses = scene.map_poses;
    query.true_poses = scene.map_poses;
    query.hypotheses = {poseFromYaw({1, 0, 0}, 0), poseFromYaw({20, 0, 0}, 0)};
    query.error_m = 0.03;
    scene.marks = {{"gone", {200, 0, 0}, {5, 5, 0}, "<b>a pole</b>"},
                   {"gone (moves anyway)", {220, 160, 160}, {6, 5, 0}, "a car", false}};
    query.marks = {{"agrees", {0, 200, 0}, {1, 2, 3}, "a pole"}};
    scene.queries = {query};
    scene.charts = {
        {"errors", "distance", "share", ChartAxis::length, {{"all", {{0.01, 0.5}, {1, 1}}}}}};
    scene.facts = {{"median error", "3 cm"}};
  }
};

TEST(Page, HoldsMapQueryReasonsAndCharts) {
  const PageWorld world;
  const json data = dataOf(htmlPage(world.scene));
  EXPECT_EQ(data["title"], "accepted, ±2 cm");
  EXPECT_EQ(data["cloud"]["shown"], 100);
  EXPECT_EQ(decoded<std::uint16_t>(data["cloud"]["positions"]).size(), 300u);
  EXPECT_EQ(decoded<std::uint8_t>(data["cloud"]["kinds"]).size(), 100u);
  EXPECT_EQ(decoded<float>(data["graph"]["positions"]).size(), 9u);
  EXPECT_EQ(decoded<float>(data["graph"]["edges"]).size(), 18u);
  EXPECT_EQ(data["graph"]["sigmas"][2], 0.25);
  const json& query = data["queries"][0];
  EXPECT_EQ(query["status"], "accepted");
  EXPECT_EQ(query["error"], 0.03);
  EXPECT_TRUE(query["sigma"].is_null()) << "what is not known is null";
  EXPECT_EQ(decoded<float>(query["kept"]).size(), 6u) << "an index out of range is left out";
  EXPECT_EQ(decoded<float>(query["putative"]).size(), 6u) << "without those that were kept";
  EXPECT_EQ(query["hypotheses"].size(), 2u);
  EXPECT_EQ(query["marks"][0]["notes"][0], "a pole");
  EXPECT_EQ(data["marks"][0]["listed"], true);
  EXPECT_EQ(data["marks"][1]["listed"], false) << "shown, but not beside the picture";
  EXPECT_EQ(data["charts"][0], chartSvg(world.scene.charts[0]));
}

TEST(Page, PointsComeBackWithinTheStepOfTheirChunk) {
  const PageWorld world(5000);
  const json data = dataOf(htmlPage(world.scene));
  const auto positions = decoded<std::uint16_t>(data["cloud"]["positions"]);
  std::size_t first = 0;
  for (const json& chunk : data["cloud"]["chunks"]) {
    const double size = chunk[4];
    for (std::size_t i = first; i < first + chunk[0].get<std::size_t>(); ++i) {
      const auto coordinate = [&](std::size_t k) {
        return chunk[1 + k].get<double>() + positions[3 * i + k] / 65535.0 * size +
               data["center"][k].get<double>();
      };
      for (const std::size_t k : {0, 1})
        EXPECT_NEAR(coordinate(k), std::round(coordinate(k)), 1e-3);
    }
    first += chunk[0].get<std::size_t>();
  }
  EXPECT_EQ(first, 5000u);
}

TEST(Page, PositionsAreRelativeToTheCenter) {
  SemanticGraph graph = triangle();
  for (Vertex& v : graph.vertices) v.position += Eigen::Vector3d(500000, 4649776, 0);
  Scene scene;
  scene.map_graph = &graph;
  const json data = dataOf(htmlPage(scene));
  const auto positions = decoded<float>(data["graph"]["positions"]);
  EXPECT_FLOAT_EQ(positions[3], 15);
  EXPECT_FLOAT_EQ(positions[7], 20);
  EXPECT_DOUBLE_EQ(data["center"][0], 500015);
}

TEST(Page, CloudsAreThinnedToTheLimitAndThePageSaysSo) {
  const PageWorld world(10000);
  const json data = dataOf(htmlPage(world.scene, 1000));
  EXPECT_LE(data["cloud"]["shown"], 1000);
  EXPECT_GE(data["cloud"]["shown"], 500);
  EXPECT_EQ(data["cloud"]["total"], 10000);
}

TEST(Page, AHundredThousandPointsTakeLessThanFiveMegabytes) {
  EXPECT_LT(htmlPage(PageWorld(100000).scene).size(), 5000000u);
}

TEST(Page, AsksForNothingFromOutside) {
  const std::string page = htmlPage(PageWorld().scene);
  EXPECT_NE(page.find("Content-Security-Policy\" content=\"default-src 'none'"), std::string::npos);
  EXPECT_FALSE(std::regex_search(page.substr(0, page.find("<script")),
                                 std::regex(R"((src|href)\s*=|url\(|@import)")));
  EXPECT_EQ(page.find("<script src"), std::string::npos);
}

TEST(Page, NamesCannotBreakOutOfTheData) {
  PageWorld world;
  world.scene.title = "</script><script>alert(1)</script> \"quoted\" \xFF";
  world.scene.queries[0].name = "{{script}}<img src=x onerror=alert(2)>";
  const std::string page = htmlPage(world.scene);
  EXPECT_EQ(page.find("alert(1)</script>"), std::string::npos);
  EXPECT_EQ(page.find("<img"), std::string::npos);
  const json data = dataOf(page);
  EXPECT_EQ(data["title"].get<std::string>().substr(0, 17), "</script><script>");
  EXPECT_EQ(data["queries"][0]["name"], world.scene.queries[0].name);
}

TEST(Page, EmptySceneIsAPage) {
  const json data = dataOf(htmlPage({}));
  EXPECT_TRUE(data["cloud"].is_null());
  EXPECT_GT(data["radius"], 0);
}

TEST(Page, NumbersThatAreNotFiniteAreLeftOut) {
  PageWorld world;
  world.graph.vertices[0].position.z() = std::numeric_limits<double>::quiet_NaN();
  world.cloud.points[3].y = std::numeric_limits<float>::infinity();
  world.scene.queries[0].poses[1].translation().x() = std::numeric_limits<double>::quiet_NaN();
  const json data = dataOf(htmlPage(world.scene));
  EXPECT_EQ(decoded<float>(data["graph"]["positions"]).size(), 6u);
  EXPECT_EQ(data["cloud"]["shown"], 99);
  EXPECT_TRUE(data["queries"][0]["pose"].is_null());
}

TEST(Page, ChartsAreWellFormedForAnyName) {
  for (const ChartAxis axis : {ChartAxis::share, ChartAxis::length, ChartAxis::odds}) {
    SceneChart chart{"</svg>&\"", "x", "y", axis, {}};
    chart.curves = {{"<a>", {{0, 0}, {0.5, std::nan("")}, {1, 1}}}, {"b", {{0.01, 1}}}};
    const std::string svg = chartSvg(chart);
    EXPECT_EQ(svg.find("</svg>"), svg.size() - 7) << "it ends once";
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    EXPECT_EQ(svg.find("<a>"), std::string::npos);
  }
}

TEST(Page, SameSceneGivesTheSameBytes) {
  EXPECT_EQ(htmlPage(PageWorld(500).scene), htmlPage(PageWorld(500).scene));
}

// ---- in a browser

/// What the page is after its scripts ran; empty if there is no browser.
std::string inBrowser(const std::string& html_path, const std::string& fragment) {
  const std::string command =
      "timeout 100 chromium --headless --no-sandbox --use-gl=angle --use-angle=swiftshader "
      "--enable-unsafe-swiftshader --window-size=1280,800 --dump-dom "
      "'file://" +
      html_path + fragment + "' 2>/dev/null";
  std::FILE* const pipe = popen(command.c_str(), "r");
  std::string dom;
  char buffer[4096];
  while (const std::size_t count = std::fread(buffer, 1, sizeof buffer, pipe))
    dom.append(buffer, count);
  pclose(pipe);
  return dom;
}

TEST(Page, DrawsFliesAndPicksInChromium) {
  if (std::system("command -v chromium > /dev/null") != 0)
    GTEST_SKIP() << "chromium is not installed: the page was not opened in a browser";
  PageWorld world(2000);
  world.scene.queries[0].name = "</li><img src=x onerror=document.title='broken'>";
  world.scene.queries[0].reason = "<b>bold</b> & \"quoted\"";
  world.cloud.points[0] = Point(15, 20, 0, 5);  // in the middle of the query
  const test::TemporaryFolder folder;
  const std::string path = folder / "page.html";
  std::ofstream(path) << htmlPage(world.scene);
  const std::string dom = inBrowser(path, "#query=1,pick");
  ASSERT_NE(dom.find("data-ready=\"yes\""), std::string::npos)
      << "a script stopped: " << dom.substr(0, 500);
  EXPECT_NE(dom.find("data-first-draw"), std::string::npos);
  EXPECT_NE(dom.find("<title>accepted, ±2 cm</title>"), std::string::npos);
  EXPECT_NE(dom.find("class=\"accepted chosen\""), std::string::npos) << "it flew to the query";
  EXPECT_NE(dom.find("&lt;img src=x"), std::string::npos);
  EXPECT_EQ(dom.find("<img"), std::string::npos);
  EXPECT_NE(dom.find("&lt;b&gt;a pole"), std::string::npos) << "places are listed";
  EXPECT_NE(dom.find("matches, kept"), std::string::npos) << "what the query shows has switches";
  EXPECT_NE(dom.find("<polyline"), std::string::npos) << "charts are drawn";
  const std::smatch picked = [&] {
    std::smatch match;
    std::regex_search(dom, match, std::regex("<output id=\"picked\"( hidden=\"\")?>([^<]*)"));
    return match;
  }();
  ASSERT_EQ(picked.size(), 3u);
  EXPECT_FALSE(picked[2].str().empty()) << "something lies where the view was flown to";
}

TEST(Page, APointOfTheMapTellsItsClassAndItsVertexInChromium) {
  if (std::system("command -v chromium > /dev/null") != 0)
    GTEST_SKIP() << "chromium is not installed: the page was not opened in a browser";
  PageWorld world(20000);
  world.scene.queries.clear();
  world.scene.marks.clear();
  world.cloud.points[0] = Point(15, 20, 1, 5);  // in the middle of the map
  const test::TemporaryFolder folder;
  const std::string path = folder / "page.html";
  std::ofstream(path) << htmlPage(world.scene);
  const std::string dom = inBrowser(path, "#pick");
  EXPECT_NE(dom.find("map point: class 5"), std::string::npos) << dom.substr(dom.size() - 1000);
  EXPECT_NE(dom.find("sigma 25 cm"), std::string::npos)
      << "that of the nearest vertex of the class";
}

}  // namespace
}  // namespace xview
