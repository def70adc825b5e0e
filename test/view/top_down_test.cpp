// SPDX-License-Identifier: BSD-3-Clause
#include "view/scene.h"

#include <gtest/gtest.h>

#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "base/pose.h"
#include "base/random.h"

namespace xview {
namespace {

constexpr Color kBlue{20, 40, 250}, kOrange{250, 140, 10};

LabelSet twoClasses() {
  LabelSet labels("two");
  ClassInfo info;
  info.id = 1;
  info.name = "lamp";
  info.color = kBlue;
  info.role = Role::object;
  info.kind = Kind::light;
  labels.add(info);
  info.id = 2;
  info.name = "wall";
  info.color = kOrange;
  info.role = Role::surface;
  info.kind = Kind::building;
  labels.add(info);
  return labels;
}

/// A world of lamps and a wall, and a query in it.
struct World {
  LabelSet labels = twoClasses();
  SemanticGraph graph, query_graph;
  LabelledCloud cloud;
  BevGrid bev;

  explicit World(double size_m = 100) {
    Random random(1);
    for (int i = 0; i < 40; ++i) {
      Vertex v;
      v.label = 1;
      v.position = {random.uniform(0, size_m), random.uniform(0, size_m), 0};
      graph.vertices.push_back(v);
    }
    graph.setEdges({{0, 1}, {2, 3}});
    query_graph.vertices.assign(graph.vertices.begin(), graph.vertices.begin() + 3);
    query_graph.setEdges({});
    for (double x = 0; x < size_m; x += 0.2) {
      Point p;
      p.x = static_cast<float>(x);
      p.y = 50;
      p.z = 1;
      p.label = 2;
      cloud.points.push_back(p);
    }
    bev[BevChannel::road].push_back({10, 10, 0});
    bev.known.push_back({20, 20, 0, true});
  }

  SceneQuery query() const {
    SceneQuery q;
    q.graph = &query_graph;
    q.cloud = &cloud;
    q.forward = Eigen::Vector3d::UnitX();
    for (int i = 0; i < 5; ++i) q.poses.push_back(poseFromYaw({40.0 + i, 30, 0}, 0));
    q.true_poses = q.poses;
    for (std::uint32_t i = 0; i < 3; ++i) q.kept.push_back({i, i, 1});
    q.putative = q.kept;
    return q;
  }

  Scene scene() const {
    Scene s;
    s.title = "a title";
    s.labels = &labels;
    s.map_graph = &graph;
    s.map_cloud = &cloud;
    s.map_poses = {poseFromYaw({0, 0, 0}, 0), poseFromYaw({5, 0, 0}, 0)};
    s.queries = {query()};
    return s;
  }
};

cv::Mat decoded(const std::string& png) {
  return cv::imdecode(std::vector<std::uint8_t>(png.begin(), png.end()), cv::IMREAD_COLOR);
}

int pixelsOf(const cv::Mat& image, const Color& color) {
  int count = 0;
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const auto& p = image.at<cv::Vec3b>(y, x);
      count += p[2] == color[0] && p[1] == color[1] && p[0] == color[2];
    }
  }
  return count;
}

const Color kQueryBlue{30, 96, 214}, kKeptGreen{20, 160, 60};

TEST(TopDown, ShowsQueryMatchesAndVerdictInTheirColors) {
  const World world;
  Scene scene = world.scene();
  const cv::Mat image = decoded(drawTopDown(scene));
  EXPECT_GT(pixelsOf(image, statusColor(Status::accepted)), 100);
  EXPECT_GT(pixelsOf(image, kKeptGreen), 50);
  EXPECT_GT(pixelsOf(image, kQueryBlue), 50);
  scene.queries.clear();
  EXPECT_EQ(pixelsOf(decoded(drawTopDown(scene)), kQueryBlue), 0);
}

TEST(TopDown, AMapWithoutACloudHasTheColorsOfItsClasses) {
  const World world;
  Scene scene;
  scene.labels = &world.labels;
  scene.map_graph = &world.graph;
  EXPECT_GT(pixelsOf(decoded(drawTopDown(scene)), kBlue), 40 * 15);
}

TEST(TopDown, CeilingsAreLeftOutUnderWhichARoomWouldDisappear) {
  World world;
  for (Point& p : world.cloud.points) p.label = 2;
  Scene scene;
  scene.labels = &world.labels;
  scene.map_cloud = &world.cloud;
  const cv::Mat drawn = decoded(drawTopDown(scene));
  ClassInfo ceiling = *world.labels.find(2);
  ceiling.name = "Ceiling";
  world.labels.add(ceiling);
  const cv::Mat left_out = decoded(drawTopDown(scene));
  ASSERT_EQ(drawn.size(), left_out.size());
  const Color paper{249, 249, 247};
  EXPECT_GT(pixelsOf(left_out, paper), pixelsOf(drawn, paper) + 100);
}

TEST(TopDown, APngKeepsTheCommandThatMadeIt) {
  const World world;
  Scene scene = world.scene();
  scene.made_by = "xview view town.xvm";
  const std::string png = drawTopDown(scene);
  EXPECT_NE(png.find("xview view town.xvm"), std::string::npos);
  EXPECT_FALSE(decoded(png).empty());
}

TEST(TopDown, NothingOfTheQueryIsDrawnWithoutAPose) {
  const World world;
  Scene scene = world.scene();
  scene.queries[0].has_pose = false;
  scene.queries[0].kept.clear();
  const cv::Mat image = decoded(drawTopDown(scene));
  EXPECT_EQ(pixelsOf(image, statusColor(Status::accepted)), 0);
}

TEST(TopDown, SvgIsADrawingOfVectors) {
  const World world;
  Scene scene = world.scene();
  const std::string svg = drawTopDown(scene, PictureFormat::svg);
  EXPECT_NE(svg.find("<svg"), std::string::npos);
  EXPECT_NE(svg.find("</svg>"), std::string::npos);
  EXPECT_NE(svg.find("<path"), std::string::npos);
}

TEST(TopDown, ColorOfThePoseTellsTheStatus) {
  const World world;
  Scene scene = world.scene();
  scene.queries[0].kept.clear();
  scene.queries[0].status = Status::rejected;
  const cv::Mat image = decoded(drawTopDown(scene));
  EXPECT_GT(pixelsOf(image, statusColor(Status::rejected)), 100);
  EXPECT_EQ(pixelsOf(image, statusColor(Status::accepted)), 0);
}

TEST(TopDown, NorthIsUpAndEastIsRight) {
  LabelSet labels = twoClasses();
  ClassInfo thing = *labels.find(2);
  thing.role = Role::object;
  labels.add(thing);
  SemanticGraph graph;
  graph.vertices.resize(3);
  graph.vertices[0].position = {0, 0, 0};
  graph.vertices[1].position = {100, 0, 0};
  graph.vertices[2].position = {0, 100, 0};
  graph.vertices[1].label = 1;
  graph.vertices[2].label = 2;
  graph.setEdges({});
  Scene scene;
  scene.labels = &labels;
  scene.map_graph = &graph;
  const cv::Mat image = decoded(drawTopDown(scene));
  const auto meanOf = [&](const Color& color) {
    double x = 0, y = 0;
    int count = 0;
    for (int v = 0; v < image.rows - 60; ++v) {  // without the legend
      for (int u = 0; u < image.cols; ++u) {
        const auto& p = image.at<cv::Vec3b>(v, u);
        if (p[2] != color[0] || p[1] != color[1] || p[0] != color[2]) continue;
        x += u;
        y += v;
        ++count;
      }
    }
    EXPECT_GT(count, 2);
    return Eigen::Vector2d(x / count, y / count);
  };
  const Eigen::Vector2d east = meanOf(kBlue), north = meanOf(kOrange);
  EXPECT_GT(east.x(), north.x() + 300);
  EXPECT_LT(north.y(), east.y() - 300);
  EXPECT_NEAR(east.x() - north.x(), east.y() - north.y(), 3);  // one scale
}

TEST(TopDown, SmallQueryGetsAPanelOfItsOwn) {
  for (const bool is_small : {false, true}) {
    const World world(is_small ? 3000 : 100);
    Scene scene = world.scene();
    if (is_small) {  // its way alone
      scene.queries[0].graph = nullptr;
      scene.queries[0].cloud = nullptr;
    }
    const cv::Mat image = decoded(drawTopDown(scene));
    int white_columns = 0;  // a gap between panels, which are not quite white
    for (int x = 300; x < image.cols - 300; ++x) {
      const cv::Mat column = image(cv::Range(80, image.rows - 120), cv::Range(x, x + 1));
      white_columns += cv::countNonZero(column.reshape(1) != 255) == 0;
    }
    EXPECT_EQ(white_columns > 5, is_small);
  }
}

TEST(TopDown, ThePictureHasTheShapeOfThePlace) {
  SemanticGraph graph;
  graph.vertices.resize(2);
  graph.vertices[1].position = {1000, 200, 0};
  graph.setEdges({});
  Scene scene;
  scene.map_graph = &graph;
  const cv::Mat wide = decoded(drawTopDown(scene));
  EXPECT_GT(wide.cols, 2 * wide.rows);
  graph.vertices[1].position = {1000, 1000, 0};
  const cv::Mat square = decoded(drawTopDown(scene));
  EXPECT_GT(square.rows, 2 * wide.rows);
}

TEST(TopDown, BevGridIsDrawnWithoutACloud) {
  const World world;
  Scene scene;
  scene.map_bev = &world.bev;
  const cv::Mat image = decoded(drawTopDown(scene));
  EXPECT_GT(pixelsOf(image, {208, 210, 216}), 100);
}

TEST(TopDown, SameSceneGivesTheSameBytes) {
  const World world;
  EXPECT_EQ(drawTopDown(world.scene()), drawTopDown(world.scene()));
}

TEST(TopDown, EmptySceneIsAPicture) {
  EXPECT_GT(decoded(drawTopDown({})).rows, 400);
  const SemanticGraph graph;
  const LabelledCloud cloud;
  const BevGrid bev;
  Scene scene;
  scene.map_graph = &graph;
  scene.map_cloud = &cloud;
  scene.map_bev = &bev;
  scene.queries.resize(2);
  scene.queries[0].graph = &graph;
  scene.queries[0].kept = {{3, 4, 1}};
  EXPECT_GT(decoded(drawTopDown(scene)).rows, 400);
}

TEST(TopDown, NumbersThatAreNotFiniteAreLeftOut) {
  World world;
  world.graph.vertices[0].position.x() = std::numeric_limits<double>::quiet_NaN();
  world.cloud.points[3].y = std::numeric_limits<float>::infinity();
  Scene scene = world.scene();
  scene.map_poses[0].translation().x() = std::numeric_limits<double>::quiet_NaN();
  scene.queries[0].true_poses[4].translation().y() = std::numeric_limits<double>::infinity();
  scene.lines.push_back(
      {"line", {0, 0, 0}, {{0, 0, 0}, {std::numeric_limits<double>::quiet_NaN(), 0, 0}}});
  EXPECT_GT(decoded(drawTopDown(scene)).rows, 400);
}

TEST(TopDown, SinglePointAndHugeExtentHaveAPicture) {
  for (const double reach : {0.0, 1e-9, 1e7}) {
    SemanticGraph graph;
    graph.vertices.resize(2);
    graph.vertices[1].position = {reach, 0, 0};
    graph.setEdges({{0, 1}});
    Scene scene;
    scene.map_graph = &graph;
    EXPECT_FALSE(drawTopDown(scene).empty()) << reach;
  }
}

TEST(TopDown, TitleMayBeLongAndHaveAnyLetters) {
  Scene scene;
  scene.title = std::string(5000, 'x') +
                "Stra\xC3\x9F"
                "e\n\xFF \xED\xA0\x80 \xF5\x80 \xE2\x82";
  EXPECT_FALSE(drawTopDown(scene).empty());
}

TEST(TopDown, ManyClassesEndWithACount) {
  SemanticGraph graph;
  for (std::uint32_t i = 0; i < 500; ++i) {
    Vertex v;
    v.label = i;
    v.position = {double(i), 0, 0};
    graph.vertices.push_back(v);
  }
  graph.setEdges({});
  Scene scene;
  scene.map_graph = &graph;
  EXPECT_FALSE(drawTopDown(scene).empty());
}

}  // namespace
}  // namespace xview
