// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <tuple>

#include "base/random.h"
#include "support/test_data.h"
#include "xview/base/error.h"
#include "xview/io/cloud_files.h"
#include "xview/io/recording.h"

namespace xview::io {
namespace {

constexpr const char* kMetadata = "pointcloud_map_metadata.yaml";

using Spot = std::tuple<float, float, float, std::uint32_t>;
std::vector<Spot> spotsOf(const LabelledCloud& cloud) {
  std::vector<Spot> spots;
  for (const Point& p : cloud.points) spots.emplace_back(p.x, p.y, p.z, p.label);
  std::sort(spots.begin(), spots.end());
  return spots;
}

LabelSet poles() {
  LabelSet labels("test");
  ClassInfo info;
  info.id = 7;
  info.name = "pole";
  labels.add(info);
  return labels;
}

LabelledCloud around(double x, double y, std::size_t points) {
  Random random(11);
  LabelledCloud cloud;
  for (std::size_t i = 0; i < points; ++i)
    cloud.points.push_back(Point(static_cast<float>(x + random.uniform(-50, 50)),
                                 static_cast<float>(y + random.uniform(-30, 30)),
                                 static_cast<float>(random.uniform(0, 5)), 7));
  return cloud;
}

class CloudTiles : public ::testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) const {
    test::writeText(tiles_ + "/" + name, text);
  }
  /// Two tiles of 20 m with a point each, beside their metadata.
  void writeTwo(const std::string& metadata) const {
    write(kMetadata, metadata);
    for (const auto& [name, x] : {std::pair("A.pcd", 5.F), std::pair("B.pcd", 25.F)}) {
      LabelledCloud cloud;
      cloud.points.push_back(Point(x, 5, 0, 7));
      writePcd(tiles_ + "/" + name, cloud);
    }
  }
  std::string messageOf(const std::string& metadata) const {
    writeTwo(metadata);
    return test::messageOf<Error>([&] { openRecording(tiles_)->read(0); });
  }
  const std::string kGood = "x_resolution: 20\ny_resolution: 20.0\nA.pcd: [0, 0]\nB.pcd: [20, 0]\n";
  test::TemporaryFolder folder_;
  const std::string tiles_ = folder_ / "tiles";
};

/// Check fix for: tiles of which one had no point with an instance were refused.
TEST_F(CloudTiles, MayHoldInstancesInSomeOfThem) {
  for (const std::size_t with : {0U, 1U}) {
    LabelledCloud cloud;
    for (const float x : {5.F, 25.F}) cloud.points.push_back(Point(x, 5, 0, 7));
    cloud.points[with].instance = 3;
    writeTiles(tiles_, cloud, 20);
    EXPECT_EQ(readCloudHeader(tiles_).instance_field, "instance");
    const LabelledCloud read = readCloud(tiles_);
    ASSERT_EQ(read.size(), 2u);
    EXPECT_EQ(read.points[with].instance, 3u);
    EXPECT_EQ(read.points[1 - with].instance, 0u);
  }
}

TEST_F(CloudTiles, HoldTheSamePointsAndClasses) {
  const LabelledCloud cloud = around(0, 0, 2000);
  const LabelSet labels = poles();
  writeTiles(tiles_, cloud, 20, &labels);
  for (const std::string& path : {tiles_, tiles_ + "/pointcloud_map.pcd"}) {
    EXPECT_EQ(recogniseInput(path), InputKind::cloud) << path;
    const auto source = openRecording(path);
    ASSERT_EQ(source->size(), 1u);
    EXPECT_EQ(source->labels().className(7), "pole");
    EXPECT_EQ(spotsOf(source->read(0).cloud), spotsOf(cloud)) << path;
    EXPECT_EQ(readCloudHeader(path).points, cloud.size());
  }
}

TEST_F(CloudTiles, LieInTheirSquaresAsAutowareReadsThem) {
  writeTiles(tiles_, around(0, 0, 2000), 20);
  std::size_t tiles = 0;
  const std::string metadata = test::readText(tiles_ + "/" + kMetadata);
  for (int column = -3; column < 3; ++column) {
    for (int row = -2; row < 2; ++row) {
      const std::string name =
          "tile_" + std::to_string(column) + "_" + std::to_string(row) + ".pcd";
      const std::string corner =
          std::to_string(20 * column) + ", " + std::to_string(20 * row);  // whole numbers
      EXPECT_NE(metadata.find("\n" + name + ": [" + corner + "]\n"), std::string::npos) << name;
      for (const Point& p : readCloud(tiles_ + "/pointcloud_map.pcd/" + name).points) {
        EXPECT_TRUE(p.x >= 20.F * static_cast<float>(column) &&
                    p.x <= 20.F * static_cast<float>(column + 1) &&
                    p.y >= 20.F * static_cast<float>(row) &&
                    p.y <= 20.F * static_cast<float>(row + 1));
      }
      ++tiles;
    }
  }
  EXPECT_EQ(std::count(metadata.begin(), metadata.end(), '\n'), tiles + 2);
}

TEST_F(CloudTiles, OfBeforeAreReplaced) {
  writeTiles(tiles_, around(0, 0, 2000), 20);
  writeTiles(tiles_, around(500, 0, 100), 50);
  EXPECT_EQ(readCloud(tiles_).size(), 100u);
  EXPECT_TRUE(readCloudHeader(tiles_).notes.empty());
}

TEST_F(CloudTiles, KeepMillimetresFarFromTheOrigin) {
  LabelledCloud cloud = around(0, 0, 500);
  cloud.origin = {500000, 5000000, 0};
  writeTiles(tiles_, cloud, 20);
  const LabelledCloud read = readCloud(tiles_);
  ASSERT_EQ(read.size(), cloud.size());
  const auto sumOf = [](const LabelledCloud& c) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < c.size(); ++i) sum += c.position(i);
    return sum;
  };
  EXPECT_LT((sumOf(read) - sumOf(cloud)).norm() / static_cast<double>(cloud.size()), 1e-4);
}

TEST_F(CloudTiles, TooManyAreRefused) {
  LabelledCloud cloud;
  for (int i = 0; i < 60000; ++i) cloud.points.push_back(Point(static_cast<float>(i), 0, 0, 7));
  EXPECT_THROW(writeTiles(tiles_, cloud, 1), UsageError);
  EXPECT_FALSE(std::filesystem::exists(tiles_));
}

TEST_F(CloudTiles, AreReadBesideTheirMetadata) {
  writeTwo(kGood);
  EXPECT_EQ(readCloud(tiles_).size(), 2u);
  EXPECT_EQ(readCloudHeader(tiles_).format, "2 tiles of 20 x 20 m, PCD binary");
}

TEST_F(CloudTiles, ThatAreMissingAreNamed) {
  EXPECT_EQ(messageOf(kGood + "C.pcd: [40, 0]\n"),
            tiles_ + "/" + kMetadata + ": lists 'C.pcd', but there is no such file in " + tiles_ +
                "; copy it there or take its line out");
}

TEST_F(CloudTiles, ThatAreNotListedAreLeftOutWithANote) {
  writeTwo("x_resolution: 20\ny_resolution: 20\nA.pcd: [0, 0]\n");
  const auto source = openRecording(tiles_);
  EXPECT_EQ(source->read(0).cloud.size(), 1u);
  ASSERT_FALSE(source->notes().empty());
  EXPECT_NE(source->notes()[0].find("'B.pcd' is left out"), std::string::npos);
}

TEST_F(CloudTiles, ThatLieElsewhereAreNamed) {
  const std::string message =
      messageOf("x_resolution: 20\ny_resolution: 20\nA.pcd: [20, 0]\nB.pcd: [0, 0]\n");
  EXPECT_EQ(message.find(tiles_ + "/A.pcd: has a point at x 5.00, y 5.00, outside of the 20 x 20 m "
                                  "from [20, 0] that "),
            0u)
      << message;
}

TEST_F(CloudTiles, WithBadMetadataAreRefusedByLine) {
  const std::pair<const char*, const char*> kBad[] = {
      {"A.pcd: [0, 0]\n", "expected x_resolution and y_resolution above 0"},
      {"x_resolution: 20\ny_resolution: -20\nA.pcd: [0, 0]\n", "above 0"},
      {"x_resolution: 20\ny_resolution: 20\n", "lists no tiles"},
      {"x_resolution: 20\ny_resolution: 20\nA.pcd: [0]\n",
       ":3: 'A.pcd': expected its lower corner"},
      {"x_resolution: 20\ny_resolution: 20\nA.pcd: [0, .nan]\n", ":3: A.pcd's corner"},
      {"x_resolution: 20\ny_resolution: 20\n../A.pcd: [0, 0]\n", ":3: expected x_resolution"},
      {"x_resolution: 20\ny_resolution: 20\nA.pcd: [0, 0]\nA.pcd: [0, 0]\n",
       ":4: 'A.pcd' a second"},
      {"x_resolution: 20\ny_resolution: 20\nA.pcd: [0, 0\n", "not YAML"},
      {"- A.pcd\n", "expected `key: value` lines"},
      {"", "expected `key: value` lines"}};
  for (const auto& [metadata, expected] : kBad) {
    const std::string message = messageOf(metadata);
    EXPECT_EQ(message.find(tiles_ + "/" + kMetadata + ":"), 0u) << metadata << message;
    EXPECT_NE(message.find(expected), std::string::npos) << metadata << message;
  }
}

TEST_F(CloudTiles, WithClassesInDifferentFieldsAreRefused) {
  writeTwo(kGood);
  write("B.pcd",
        "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\n"
        "POINTS 1\nDATA ascii\n25 5 0\n");
  EXPECT_EQ(test::messageOf<Error>([&] { readCloud(tiles_); }).find(tiles_ + "/B.pcd: has its"),
            0u);
}

TEST_F(CloudTiles, CloudsBesideTheMetadataOfOthersAreNoTiles) {
  writeTwo(kGood);
  LabelledCloud cloud;
  cloud.points.push_back(Point(500, 0, 0, 7));
  std::filesystem::create_directory(tiles_ + "/queries");
  writePcd(tiles_ + "/queries/Q.pcd", cloud);
  EXPECT_EQ(recogniseInput(tiles_ + "/queries"), InputKind::cloud_folder);
}

}  // namespace
}  // namespace xview::io
