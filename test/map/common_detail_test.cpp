// SPDX-License-Identifier: BSD-3-Clause
// Maps with less detail: what is read where it is asked for is what a whole map has.
#include "map/common_detail.h"

#include <gtest/gtest.h>

#include <map>

#include "base/random.h"
#include "map/contents.h"
#include "map/sample_map.h"
#include "place/edges.h"
#include "place/shapes.h"
#include "search/distance_field.h"
#include "support/test_data.h"

namespace xview::map {
namespace {

using search::MapOverview;
using test::isSame;
using test::sampleMap;
using test::TemporaryFolder;

/// Samples of all channels and seen ground over half a square kilometre.
SemanticMap mapWithAnOverview() {
  SemanticMap map = sampleMap();
  map.size = kTownScale;
  useRadius(map.graph, {});
  Random random(3);
  map.bev.known.clear();
  for (auto& channel : map.bev.samples) channel.clear();
  for (int y = 0; y < 1400; y += 4) {
    for (int x = 0; x < 1400; x += 4) {
      map.bev.known.push_back({x, y, 0.5F, true});
      map.bev.samples[random.below(kBevChannels)].push_back(
          {static_cast<float>(x + random.uniform(0, 4)) / 2,
           static_cast<float>(y + random.uniform(0, 4)) / 2, 1});
    }
  }
  map.null.poses = 9;
  map.null.view = search::fingerprintOf(map.bev);
  return map;
}

/// All detail that can go, and classes that shapes tell.
CommonDetail shapesOnly() {
  CommonDetail detail;
  detail.shapes = detail.one_ground = detail.one_wall = detail.one_post = true;
  detail.gone = 1u << static_cast<unsigned>(BevChannel::vehicle);
  return detail;
}

class ReducedMap : public ::testing::Test {
 protected:
  void SetUp() override {
    saveMap(path, mapWithAnOverview());
    SemanticMap rounded = unpacked(openMap(path));  // as a file does
    rounded.overview.reset();
    saveMap(path, rounded);
    whole = reduced(unpacked(openMap(path)), shapesOnly(), labelsOfShapes());
    opened = reduced(openMap(path), shapesOnly(), labelsOfShapes());
    ASSERT_TRUE(opened.stored_points && opened.stored_view && opened.stored_vertices);
  }
  TemporaryFolder folder;
  const std::string path = folder / "map.xvm";
  SemanticMap whole, opened;
};

TEST_F(ReducedMap, HasTheSamePointsVerticesAndViewHoweverItWasRead) {
  EXPECT_TRUE(opened.labels == whole.labels);
  EXPECT_TRUE(isSame(viewOf(opened), whole.bev));
  for (const BevChannel gone : {BevChannel::sign, BevChannel::terrain, BevChannel::vehicle})
    EXPECT_TRUE(whole.bev[gone].empty()) << toString(gone);
  EXPECT_GT(whole.bev[BevChannel::pole].size(), whole.bev[BevChannel::pole_like].size());

  CellIndex columns;
  for (const PlaneCell& column : opened.stored_view->columns())
    columns.findOrAdd(column.x, column.y);
  EXPECT_TRUE(isSame(gathered(*opened.stored_view, columns, opened.bev), whole.bev));

  ASSERT_EQ(countsOf(opened).vertices, whole.graph.size());
  for (std::uint32_t i = 0; i < whole.graph.size(); ++i)
    EXPECT_EQ(allVertices(opened).at(i).label, whole.graph.vertices[i].label);
  opened.stored_vertices->forAll([&](std::uint32_t number, const Vertex& vertex) {
    EXPECT_EQ(vertex.label, whole.graph.vertices[number].label);
  });

  std::map<std::uint32_t, std::size_t> of_class, read_of_class;
  for (const Point& p : whole.cloud.points) ++of_class[p.label];
  for (const PlaneCell& column : opened.stored_points->columns()) {
    for (const Point& p : opened.stored_points->pointsOf(column)->points) ++read_of_class[p.label];
  }
  EXPECT_EQ(read_of_class, of_class);
  unpackPoints(opened);
  EXPECT_EQ(opened.cloud.size(), whole.cloud.size());
}

TEST_F(ReducedMap, IsSeenFromAfarAsItIs) {
  ASSERT_TRUE(opened.overview && whole.overview && hasOverview(whole));
  const MapOverview made =
      search::overviewOf(search::DistanceField(whole.bev), MapOverview::kSide, 1);
  ASSERT_EQ(made.tiles.size(), opened.overview->tiles.size());
  // One sample of a cell is looked at from afar, which may be another one of the same cell.
  std::size_t squares = 0, other_nearest = 0, other_medians = 0;
  for (std::size_t i = 0; i < made.tiles.size(); ++i) {
    EXPECT_EQ(whole.overview->tiles[i].squares, opened.overview->tiles[i].squares);
    for (std::size_t k = 0; k < made.tiles[i].squares.size(); ++k, ++squares) {
      const std::uint8_t exact = made.tiles[i].squares[k],
                         kept = opened.overview->tiles[i].squares[k];
      other_nearest += (kept & 15) != (exact & 15);
      other_medians += kept >> 4 != exact >> 4;
    }
  }
  EXPECT_LT(other_nearest, squares / 500);
  EXPECT_LT(other_medians, squares / 20);
}

TEST_F(ReducedMap, IsToldFromTheWholeOne) {
  EXPECT_NE(fingerprintOfView(opened), fingerprintOfView(openMap(path)));
  CommonDetail other = shapesOnly();
  other.gone = 0;
  EXPECT_NE(fingerprintOfView(opened),
            fingerprintOfView(reduced(openMap(path), other, labelsOfShapes())));
}

}  // namespace
}  // namespace xview::map
