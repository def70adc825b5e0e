// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "map/contents.h"
#include "map/sample_map.h"
#include "place/edges.h"
#include "support/test_data.h"
#include "xview/map/semantic_map.h"

namespace xview::map {
namespace {

using test::isSame;
using test::readText;
using test::sampleMap;
using test::TemporaryFolder;

/// A map with four columns of points in a row.
SemanticMap rowOfColumns() {
  SemanticMap map = sampleMap();
  map.cloud = {};
  map.cloud.origin = {1000, 2000, 30};
  for (int i = 0; i < 256; ++i) {
    Point point(static_cast<float>(i) + 0.25F, 10.5F, 1.F, 3);
    map.cloud.points.push_back(point);
  }
  return map;
}

class PackedCloudTest : public ::testing::Test {
 protected:
  void SetUp() override {
    saveMap(folder / "map.xvm", rowOfColumns());
    opened = openMap(folder / "map.xvm");
  }
  TemporaryFolder folder;
  SemanticMap opened;
};

TEST_F(PackedCloudTest, AnOpenedMapHoldsItsPointsPacked) {
  EXPECT_TRUE(opened.cloud.empty());
  EXPECT_EQ(countsOf(opened).points, 256u);
  EXPECT_EQ(opened.stored_points->columns().size(), 4u);
  EXPECT_EQ(opened.stored_points->pointsOf({1, 0})->size(), 64u);
  EXPECT_EQ(opened.stored_points->pointsOf({7, 0})->size(), 0u);
  unpackPoints(opened);
  EXPECT_EQ(opened.stored_points, nullptr);
  EXPECT_TRUE(isSame(opened, unpacked(openMap(folder / "map.xvm"))));
}

TEST_F(PackedCloudTest, OnlyTheColumnsOfNewPointsAreUnpacked) {
  LabelledCloud near;
  near.origin = {1000, 2000, 0};
  near.points.emplace_back(70.F, 3.F, 0.F);
  near.points.emplace_back(-70.F, 3.F, 0.F);
  unpackPointsAround(near, opened);
  ASSERT_EQ(opened.cloud.size(), 64u);
  EXPECT_EQ(opened.cloud.points[0].x, 64.25F);
  EXPECT_EQ(opened.stored_points->columns().size(), 3u);
  EXPECT_EQ(countsOf(opened).points, 256u);
}

TEST_F(PackedCloudTest, APartlyUnpackedMapIsWrittenAsItWas) {
  LabelledCloud near;
  near.origin = {1000, 2000, 0};
  near.points.emplace_back(130.F, 3.F, 0.F);
  unpackPointsAround(near, opened);
  saveMap(folder / "again.xvm", opened);
  EXPECT_EQ(readText(folder / "again.xvm"), readText(folder / "map.xvm"));
}

TEST_F(PackedCloudTest, APointInAPackedColumnIsNotWritten) {
  opened.cloud.points.emplace_back(1.F, 1.F, 1.F, 3);
  EXPECT_NE(test::messageOf<std::exception>([&] {
              saveMap(folder / "other.xvm", opened);
            }).find("packed and unpacked"),
            std::string::npos);
}

TEST(StoredEdges, ThoseOfARadiusAreMadeAnew) {
  SemanticMap map = rowOfColumns();
  connectByRadius(map.graph, {5000});
  ASSERT_GT(map.graph.edgeCount(), 0u);
  const TemporaryFolder folder;
  saveMap(folder / "map.xvm", map);
  SemanticMap read = openMap(folder / "map.xvm");
  EXPECT_EQ(read.graph.edge_radius_m, 5000);
  EXPECT_TRUE(read.graph.neighbours.empty());
  unpackVertices(read);
  makeEdges(read.graph);
  EXPECT_EQ(read.graph.neighbours, map.graph.neighbours);
}

TEST(StoredNoise, IsThatOfTheMap) {
  SemanticMap map = rowOfColumns();
  map.noise = pose::SurfaceNoise{0.8, 0.0123, true};
  const TemporaryFolder folder;
  saveMap(folder / "map.xvm", map);
  const SemanticMap read = openMap(folder / "map.xvm");
  ASSERT_TRUE(read.noise);
  EXPECT_EQ(read.noise->cell_m, 0.8);
  EXPECT_EQ(read.noise->thickness_m, 0.0123);
  EXPECT_TRUE(read.noise->is_sparse);
}

}  // namespace
}  // namespace xview::map
