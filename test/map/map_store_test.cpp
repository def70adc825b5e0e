// SPDX-License-Identifier: BSD-3-Clause
#include "xview/map/semantic_map.h"

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Statement.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>

#include "map/sample_map.h"
#include "support/test_data.h"
#include "xview/base/error.h"

namespace xview::map {
namespace {

using test::isSame;
using test::readText;
using test::sampleMap;
using test::TemporaryFolder;

SemanticMap throughFile(const SemanticMap& map) {
  const TemporaryFolder folder;
  saveMap(folder / "map.xvm", map);
  return unpacked(openMap(folder / "map.xvm"));
}

std::string messageOfSave(const std::string& path, const SemanticMap& map) {
  return test::messageOf<Error>([&] { saveMap(path, map); });
}

template <class Point>
std::vector<std::array<double, 3>> sortedPositions(const std::vector<Point>& points) {
  std::vector<std::array<double, 3>> all;
  for (const Point& p : points)
    all.push_back({std::round(p.x * 100.0), std::round(p.y * 100.0), std::round(p.z * 100.0)});
  std::sort(all.begin(), all.end());
  return all;
}

TEST(MapStore, KeepsGraphLabelsKeyframesAndTextsExactly) {
  const SemanticMap map = sampleMap(), loaded = throughFile(map);
  EXPECT_TRUE(isSame(loaded.labels, map.labels));
  EXPECT_TRUE(isSame(loaded.graph, map.graph));
  ASSERT_EQ(loaded.poses.size(), map.poses.size());
  for (std::size_t i = 0; i < map.poses.size(); ++i)
    EXPECT_EQ(loaded.poses[i].matrix(), map.poses[i].matrix());
  EXPECT_EQ(loaded.stamps_s, map.stamps_s);
  EXPECT_EQ(loaded.frames, map.frames);
  EXPECT_EQ(loaded.source_of_pose, map.source_of_pose);
  EXPECT_EQ(loaded.sources, map.sources);
  EXPECT_EQ(loaded.options_yaml, map.options_yaml);
  ASSERT_EQ(loaded.wrong_places.size(), map.wrong_places.size());
  for (std::size_t i = 0; i < map.wrong_places.size(); ++i) {
    EXPECT_EQ(loaded.wrong_places[i].above_null, map.wrong_places[i].above_null);
    EXPECT_EQ(loaded.wrong_places[i].miss_ratio, map.wrong_places[i].miss_ratio);
    EXPECT_EQ(loaded.wrong_places[i].dense_margin, map.wrong_places[i].dense_margin);
    EXPECT_EQ(loaded.wrong_places[i].likelihood_margin, map.wrong_places[i].likelihood_margin);
  }
  ASSERT_EQ(loaded.own_stretches.size(), map.own_stretches.size());
  for (std::size_t i = 0; i < map.own_stretches.size(); ++i) {
    EXPECT_EQ(loaded.own_stretches[i].window_m, map.own_stretches[i].window_m);
    EXPECT_EQ(loaded.own_stretches[i].confidence, map.own_stretches[i].confidence);
  }
}

TEST(MapStore, KeepsTheBevGridToACentimetre) {
  const SemanticMap map = sampleMap(), loaded = throughFile(map);
  EXPECT_EQ(loaded.bev.origin_y, map.bev.origin_y);
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    EXPECT_EQ(sortedPositions(loaded.bev.samples[c]), sortedPositions(map.bev.samples[c])) << c;
  }
  ASSERT_EQ(loaded.bev.known.size(), map.bev.known.size());
  for (std::size_t i = 0; i < map.bev.known.size(); ++i) {
    const GroundCell &is = loaded.bev.known[i], &was = map.bev.known[i];
    EXPECT_EQ(is.x, was.x);
    EXPECT_EQ(is.y, was.y);
    EXPECT_NEAR(is.z, was.z, 0.00501);
    EXPECT_EQ(is.measured, was.measured);
  }
}

TEST(MapStore, KeepsTheBevGridForAnyCellSize) {
  for (const double cell_m : {0.1, 0.3, 1.0 / 3, 0.5, 2.7}) {
    SemanticMap map;
    map.bev = sampleMap().bev;
    map.bev.cell_m = cell_m;
    const SemanticMap loaded = throughFile(map);
    for (std::size_t c = 0; c < kBevChannels; ++c) {
      EXPECT_EQ(sortedPositions(loaded.bev.samples[c]), sortedPositions(map.bev.samples[c]))
          << c << " " << cell_m;
    }
  }
}

TEST(MapStore, KeepsEveryPointOfTheCloudToACentimetreWithItsLabelAndInstance) {
  const SemanticMap map = sampleMap(), loaded = throughFile(map);
  EXPECT_EQ(loaded.cloud.origin, map.cloud.origin);
  ASSERT_EQ(loaded.cloud.size(), map.cloud.size());
  const auto rows = [](const LabelledCloud& cloud) {
    std::vector<std::array<double, 5>> all;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const auto& p = cloud.points[i];
      all.push_back({std::round(p.x * 100.0), std::round(p.y * 100.0), std::round(p.z * 100.0),
                     double(p.label), double(p.instance)});
    }
    std::sort(all.begin(), all.end());
    return all;
  };
  EXPECT_EQ(rows(loaded.cloud), rows(map.cloud));
  EXPECT_EQ(loaded.cloud.points.width, map.cloud.size());
  EXPECT_EQ(loaded.cloud.points.height, 1u);
}

TEST(MapStore, SecondRoundTripChangesNothing) {
  const SemanticMap once = throughFile(sampleMap());
  EXPECT_TRUE(isSame(throughFile(once), once));
}

TEST(MapStore, EmptyMapIsAMap) {
  const SemanticMap loaded = throughFile(SemanticMap());
  EXPECT_TRUE(isSame(loaded, SemanticMap()));
}

TEST(MapStore, BareGraphNeedsNeitherBevNorCloud) {
  SemanticMap map;
  map.graph.vertices.resize(5000);
  map.graph.setEdges({{0, 4999}, {4095, 4096}, {1, 2}});
  EXPECT_TRUE(isSame(throughFile(map), map));
}

TEST(MapStore, KeepsTheSpaceOfTheGraph) {
  SemanticMap map = sampleMap();
  EXPECT_EQ(throughFile(map).graph.space, GraphSpace::cloud);
  map.graph.space = GraphSpace::image;
  EXPECT_EQ(throughFile(map).graph.space, GraphSpace::image);
}

TEST(MapStore, CloudWithoutInstancesStaysWithout) {
  SemanticMap map = sampleMap();
  for (Point& p : map.cloud.points) p.instance = 0;
  EXPECT_FALSE(throughFile(map).cloud.hasInstances());
}

TEST(MapStore, DropsPointsThatAreNotFinite) {
  SemanticMap map = sampleMap();
  map.cloud.points[5].y = std::numeric_limits<float>::quiet_NaN();
  map.cloud.points[6].z = std::numeric_limits<float>::infinity();
  EXPECT_EQ(throughFile(map).cloud.size(), map.cloud.size() - 2);
}

TEST(MapStore, UnknownTimeOfAKeyframeStaysUnknown) {
  SemanticMap map = sampleMap();
  map.stamps_s[3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(throughFile(map).stamps_s[3]));
}

TEST(MapStore, SameMapGivesSameBytes) {
  const TemporaryFolder folder;
  saveMap(folder / "a.xvm", sampleMap());
  saveMap(folder / "b.xvm", sampleMap());
  EXPECT_EQ(readText(folder / "a.xvm"), readText(folder / "b.xvm"));
}

TEST(MapStore, OrderOfPointsAndSamplesDoesNotChangeTheBytes) {
  const TemporaryFolder folder;
  SemanticMap map = sampleMap();
  saveMap(folder / "a.xvm", map);
  std::reverse(map.cloud.points.begin(), map.cloud.points.end());
  for (auto& samples : map.bev.samples) std::reverse(samples.begin(), samples.end());
  saveMap(folder / "b.xvm", map);
  EXPECT_EQ(readText(folder / "a.xvm"), readText(folder / "b.xvm"));
}

TEST(MapStore, SavingTheSameMapAgainWritesNothing) {
  const TemporaryFolder folder;
  saveMap(folder / "a.xvm", sampleMap());
  const std::string before = readText(folder / "a.xvm");
  saveMap(folder / "a.xvm", sampleMap());
  EXPECT_EQ(readText(folder / "a.xvm"), before);
}

TEST(MapStore, ReplacesAnExistingMap) {
  const TemporaryFolder folder;
  saveMap(folder / "a.xvm", sampleMap(1));
  saveMap(folder / "a.xvm", SemanticMap());
  EXPECT_TRUE(isSame(unpacked(openMap(folder / "a.xvm")), SemanticMap()));
  saveMap(folder / "a.xvm", sampleMap(2));
  EXPECT_TRUE(isSame(unpacked(openMap(folder / "a.xvm")), throughFile(sampleMap(2))));
}

TEST(MapStore, LeavesNoOtherFile) {
  const TemporaryFolder folder;
  saveMap(folder / "a.xvm", sampleMap(1));
  saveMap(folder / "a.xvm", sampleMap(2));
  unpacked(openMap(folder / "a.xvm"));
  const auto files = std::filesystem::directory_iterator(folder.path());
  EXPECT_EQ(std::distance(begin(files), end(files)), 1);
}

TEST(MapStore, FileSaysWhichProgramWroteIt) {
  EXPECT_FALSE(throughFile(sampleMap()).program_version.empty());
}

TEST(MapStore, AnySqliteToolCanReadTheKeyFrames) {
  const TemporaryFolder folder;
  const SemanticMap map = sampleMap();
  saveMap(folder / "a.xvm", map);
  SQLite::Database database(folder / "a.xvm");
  SQLite::Statement query(database, "SELECT x, number FROM keyframes WHERE id = 1");
  ASSERT_TRUE(query.executeStep());
  EXPECT_EQ(query.getColumn(0).getDouble(), map.poses[1].translation().x());
  EXPECT_EQ(query.getColumn(1).getInt64(), map.frames[1]);
}

TEST(MapStore, KilometreOfStreetCostsLessThanAMegabyte) {
  const TemporaryFolder folder;
  SemanticMap map;
  map.bev = test::streetBev(1000, 1);
  saveMap(folder / "a.xvm", map);
  const auto size = std::filesystem::file_size(folder / "a.xvm");
  RecordProperty("bytes", static_cast<int>(size));
  EXPECT_LT(size, 1000u * 1000u);
}

TEST(MapStore, RefusesAMapThatCouldNotBeReadBack) {
  const TemporaryFolder folder;
  const std::string path = folder / "a.xvm";
  SemanticMap map = sampleMap();
  map.graph.vertices[4].position.y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(messageOfSave(path, map).find("vertex 4"), std::string::npos);
  map = sampleMap();
  map.graph.neighbours[0].push_back(0);
  EXPECT_NE(messageOfSave(path, map).find("inconsistent"), std::string::npos);
  map = sampleMap();
  map.source_of_pose[2] = 2;
  EXPECT_NE(messageOfSave(path, map).find("source 2"), std::string::npos);
  map = sampleMap();
  map.poses[2].linear() *= 2;
  EXPECT_NE(messageOfSave(path, map).find("key frame 2"), std::string::npos);
  map = sampleMap();
  map.cloud.points[0].x = 1e20f;
  EXPECT_NE(messageOfSave(path, map).find("fit into a map"), std::string::npos);
  map = sampleMap();
  map.bev[BevChannel::pole][0].x = std::numeric_limits<float>::infinity();
  EXPECT_NE(messageOfSave(path, map).find("plan view"), std::string::npos);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(MapStore, EveryMessageBeginsWithThePath) {
  SemanticMap map = sampleMap();
  map.source_of_pose[2] = 2;
  const TemporaryFolder folder;
  EXPECT_EQ(messageOfSave(folder / "a.xvm", map).rfind(folder / "a.xvm: ", 0), 0u);
}

}  // namespace
}  // namespace xview::map
