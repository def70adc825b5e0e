// SPDX-License-Identifier: BSD-3-Clause
// Graphs whose blobs and edges come from images, as in the paper, against each other and against
// graphs in space.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "localizer/simulated_drive.h"
#include "match/walk_matching.h"
#include "xview/base/error.h"

namespace xview {

namespace {

using test::simulatedDrive;

Options walksIn(const std::string& space) {
  Options options;
  options.method = "walks";
  options.graph_space = space;
  return options;
}

const std::vector<PreprocessedFrame>& imageFrames(const std::string& session) {
  static std::map<std::string, std::vector<PreprocessedFrame>> frames;
  auto& found = frames[session];
  if (found.empty())
    found = preprocessRecording(*simulatedDrive().sessions.at(session), walksIn("image"));
  return found;
}

const map::SemanticMap& imageMap() {
  static const map::SemanticMap map =
      buildMap({simulatedDrive().sessions.at("forward").get()}, walksIn("image"));
  return map;
}

Query imageQuery(const std::string& session, std::size_t first, std::size_t last) {
  const auto& frames = imageFrames(session);
  return makeQuery(frames.data() + first, frames.data() + last, simulatedDrive().labels,
                   walksIn("image"));
}

double errorInImages(const Localization& fix, const std::string& session, std::size_t last_frame) {
  const Eigen::Isometry3d truth = simulatedDrive().sessions.at(session)->truth(last_frame);
  return (fix.T_map_sensor.translation() - truth.translation()).norm();
}

TEST(ImageSpace, AMapHasVerticesOfSurfacesAndObjectsAndEdgesOfTheImages) {
  const SemanticGraph& graph = imageMap().graph;
  EXPECT_EQ(graph.space, GraphSpace::image);
  EXPECT_TRUE(isConsistent(graph));
  EXPECT_GT(graph.size(), 30u);
  EXPECT_GT(graph.edgeCount(), graph.size());
  std::set<Role> roles;
  for (const Vertex& v : graph.vertices) roles.insert(imageMap().labels.role(v.label));
  EXPECT_TRUE(roles.count(Role::surface));
  EXPECT_TRUE(roles.count(Role::object));
  // What is far apart in space may be neighbours in an image: edges are not those of a radius.
  const auto edges = graph.edges();
  EXPECT_TRUE(std::any_of(edges.begin(), edges.end(), [&](const auto& e) {
    return (graph.vertices[e.first].position - graph.vertices[e.second].position).norm() >
           EdgeOptions().radius_m;
  }));
  EXPECT_GT(imageMap().bev.sampleCount(), 1000u);
}

TEST(ImageSpace, WalksKeepTheEdgesOfTheImages) {
  const match::WalkGraph walks = match::walkGraph(imageMap().graph, imageMap().labels, walksIn("image"));
  EXPECT_EQ(walks.graph.neighbours, imageMap().graph.neighbours);
  EXPECT_NE(
      match::walkGraph(simulatedDrive().map.graph, imageMap().labels, walksIn("image")).graph.neighbours,
      simulatedDrive().map.graph.neighbours);
}

TEST(ImageSpace, PartsOfAGraphHaveTheEdgesAmongTheirVertices) {
  const SemanticGraph& graph = imageMap().graph;
  std::vector<std::uint32_t> even;
  for (std::uint32_t i = 0; i < graph.size(); i += 2) even.push_back(i);
  const SemanticGraph part = match::inducedGraph(graph, even);
  EXPECT_TRUE(isConsistent(part));
  EXPECT_EQ(part.space, GraphSpace::image);
  std::size_t edges = 0;
  for (const auto& [a, b] : graph.edges()) edges += a % 2 == 0 && b % 2 == 0;
  EXPECT_EQ(part.edgeCount(), edges);
}

TEST(ImageSpace, RegionsAreTheVerticesOfTheImagesWithEdgesInSpace) {
  const FrameSource* rear = simulatedDrive().sessions.at("rear").get();
  const SemanticGraph images = makeQuery(*rear, walksIn("image")).graph;
  SemanticGraph regions = makeQuery(*rear, walksIn("regions")).graph;
  ASSERT_EQ(regions.size(), images.size());
  for (std::size_t i = 0; i < regions.size(); ++i)
    EXPECT_EQ(regions.vertices[i].position, images.vertices[i].position);
  SemanticGraph in_space = images;
  connectByRadius(in_space, EdgeOptions());
  makeEdges(regions);
  EXPECT_EQ(regions.neighbours, in_space.neighbours);
  EXPECT_NE(regions.neighbours, images.neighbours);
  EXPECT_EQ(regions.space, GraphSpace::cloud);
}

TEST(ImageSpace, AQueryIsFoundByWalksInAMapOfImageSpace) {
  const Localization fix =
      Localizer(imageMap(), walksIn("image")).localize(imageQuery("rear", 10, 45));
  EXPECT_LT(errorInImages(fix, "rear", 44), 2) << fix.reason;
}

TEST(ImageSpace, AQueryIsFoundByWalksInAMapInSpace) {
  const Localization fix =
      Localizer(simulatedDrive().map, walksIn("image")).localize(imageQuery("rear", 10, 45));
  EXPECT_LT(errorInImages(fix, "rear", 44), 2) << fix.reason;
}

TEST(ImageSpace, AQueryInSpaceIsFoundByWalksInAMapOfImageSpace) {
  const Localization fix =
      Localizer(imageMap(), walksIn("cloud")).localize(simulatedDrive().query("rear", 10, 45));
  EXPECT_LT(errorInImages(fix, "rear", 44), 2) << fix.reason;
}

TEST(ImageSpace, AnotherTownIsRefused) {
  const Localizer localizer(imageMap(), walksIn("image"));
  for (std::size_t first = 0; first + 30 <= imageFrames("elsewhere").size(); first += 15) {
    const Localization fix = localizer.localize(imageQuery("elsewhere", first, first + 30));
    EXPECT_NE(fix.status, Status::accepted) << "frames from " << first << ": " << fix.reason;
  }
}

TEST(ImageSpace, ThePlaceSearchAnswersAsItDoesOtherwise) {
  Options search;
  search.method = "search";
  const Localization of_images = Localizer(imageMap(), search).localize(imageQuery("rear", 10, 40));
  const Localization of_clouds =
      Localizer(simulatedDrive().map, search).localize(simulatedDrive().query("rear", 10, 40));
  EXPECT_EQ(of_images.status, of_clouds.status);
  EXPECT_EQ(of_images.T_map_query.matrix(), of_clouds.T_map_query.matrix());
  Options automatic;
  const Localization both = Localizer(imageMap(), automatic).localize(imageQuery("rear", 10, 40));
  EXPECT_EQ(both.status, Status::accepted) << both.reason;
  EXPECT_LT(errorInImages(both, "rear", 39), 0.5);
}

TEST(ImageSpace, ThreadsDoNotChangeTheGraph) {
  Options one = walksIn("image"), two = one;
  one.threads = 1;
  two.threads = 2;
  const FrameSource* rear = simulatedDrive().sessions.at("rear").get();
  const SemanticGraph a = makeQuery(*rear, one).graph;
  const SemanticGraph b = makeQuery(*rear, two).graph;
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(a.neighbours, b.neighbours);
  for (std::size_t i = 0; i < a.size(); ++i)
    EXPECT_EQ(a.vertices[i].position, b.vertices[i].position);
}

TEST(ImageSpace, AppendingKeepsTheEdgesOfBoth) {
  map::SemanticMap map = imageMap();
  appendToMap(map, imageMap(), {});
  EXPECT_EQ(map.graph.space, GraphSpace::image);
  EXPECT_TRUE(isConsistent(map.graph));
  EXPECT_EQ(map.graph.size(), imageMap().graph.size());
  EXPECT_EQ(map.graph.neighbours, imageMap().graph.neighbours);
}

TEST(ImageSpace, GraphsOfTwoSpacesAreNotJoined) {
  map::SemanticMap map = simulatedDrive().map;
  EXPECT_THROW(appendToMap(map, imageMap(), {}), Error);
}

TEST(ImageSpace, IsWrongUseForAnythingButImages) {
  Frame scan;
  scan.sensor = Sensor::lidar;
  EXPECT_THROW(preprocessFrame(scan, simulatedDrive().labels, walksIn("image")), UsageError);
  scan.sensor = Sensor::cloud;
  EXPECT_THROW(preprocessFrame(scan, simulatedDrive().labels, walksIn("image")), UsageError);
}

}  // namespace
}  // namespace xview
