// SPDX-License-Identifier: BSD-3-Clause
// The vertices of a map that is opened to localize, which stay packed.
#include "base/stored_vertices.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <utility>

#include "../../src/map/packed_vertices.h"
#include "base/random.h"
#include "map/contents.h"
#include "map/sample_map.h"
#include "place/edges.h"
#include "support/test_data.h"
#include "xview/base/error.h"
#include "xview/map/semantic_map.h"

namespace xview::map {
namespace {

using test::isSame;
using test::sampleMap;
using test::TemporaryFolder;

constexpr std::uint32_t kVertices = 3000;  ///< more than two blocks

/// Vertices along a street of 6 km, with edges of a radius.
SemanticMap streetMap() {
  SemanticMap map = sampleMap();
  map.size = kTownScale;
  Random random(3);
  map.graph = {};
  for (std::uint32_t i = 0; i < kVertices; ++i) {
    Vertex v;
    v.label = 3;
    v.position = {2.0 * i, random.uniform(-8, 8), random.uniform(0, 9)};
    v.points = i;
    map.graph.vertices.push_back(v);
  }
  connectByRadius(map.graph, {5});
  return map;
}

class StreetMap : public ::testing::Test {
 protected:
  StreetMap() { saveMap(path, map); }

  const TemporaryFolder folder;
  const std::string path = folder / "street.xvm";
  const SemanticMap map = streetMap();
};

TEST_F(StreetMap, KeepsItsVerticesPackedToLocalize) {
  SemanticMap opened = openMap(path);
  ASSERT_NE(opened.stored_vertices, nullptr);
  EXPECT_TRUE(opened.graph.empty());
  EXPECT_EQ(countsOf(opened).vertices, kVertices);
  const SemanticMap whole = unpacked(openMap(path));
  EXPECT_EQ(whole.stored_vertices, nullptr);
  EXPECT_EQ(countsOf(whole).vertices, kVertices);
  for (const std::uint32_t i : {0u, 1023u, 1024u, 2999u}) {
    EXPECT_EQ(allVertices(opened).at(i).points, i);
    EXPECT_EQ(allVertices(opened).at(i).position, map.graph.vertices[i].position);
    EXPECT_EQ(allVertices(whole).at(i).position, map.graph.vertices[i].position);
  }
  EXPECT_THROW(allVertices(opened).at(kVertices), std::out_of_range);

  saveMap(folder / "again.xvm", opened);
  EXPECT_TRUE(isSame(unpacked(openMap(folder / "again.xvm")), whole)) << "nothing is lost";
  unpackVertices(opened);
  EXPECT_EQ(opened.stored_vertices, nullptr);
  EXPECT_TRUE(isSame(opened.graph, whole.graph));
}

TEST_F(StreetMap, TellsWhatStandsInABox) {
  const SemanticMap opened = openMap(path);
  Eigen::AlignedBox3d around;
  for (const Vertex& v : map.graph.vertices) around.extend(v.position);
  EXPECT_TRUE(opened.stored_vertices->bounds().isApprox(around));
  const Eigen::AlignedBox2d boxes[] = {
      {Eigen::Vector2d(2000, -3), Eigen::Vector2d(2100, 5)},  // on both sides of a border of blocks
      {Eigen::Vector2d(0, 20), Eigen::Vector2d(9000, 30)},
      {Eigen::Vector2d(-9, -9), Eigen::Vector2d(9000, 9)}};
  for (const Eigen::AlignedBox2d& box : boxes) {
    std::vector<std::uint32_t> expected, found;
    for (std::uint32_t i = 0; i < kVertices; ++i) {
      if (box.contains(map.graph.vertices[i].position.head<2>())) expected.push_back(i);
    }
    opened.stored_vertices->forAllIn(box, [&](std::uint32_t number, const Vertex& v) {
      found.push_back(number);
      EXPECT_EQ(v.position, map.graph.vertices[number].position);
    });
    EXPECT_EQ(found, expected);
  }
}

TEST_F(StreetMap, ShowsAllItsVerticesInOrderWhereverTheyAre) {
  const SemanticMap opened = openMap(path);
  for (const SemanticMap* any : {&opened, &map}) {
    std::uint32_t next = 0;
    allVertices(*any).forEach([&](std::uint32_t number, const Vertex& v) {
      EXPECT_EQ(number, next++);
      EXPECT_EQ(v.position, map.graph.vertices[number].position);
    });
    EXPECT_EQ(next, kVertices);
  }
}

TEST_F(StreetMap, UnpacksVerticesWithEdgesOfTheirOwnOrOtherLengths) {
  SemanticMap other = map;
  other.graph.edge_radius_m = 0;
  saveMap(folder / "edges.xvm", other);
  other = map;
  other.size = 0.1;
  saveMap(folder / "small.xvm", other);
  for (const char* name : {"edges.xvm", "small.xvm"}) {
    const SemanticMap opened = openMap(folder / name);
    EXPECT_EQ(opened.stored_vertices, nullptr) << name;
    EXPECT_EQ(opened.graph.size(), kVertices) << name;
  }
}

TEST(StoredBlocks, OfADamagedFileGiveOneLineWithItsName) {
  std::vector<VertexBlock> blocks = toBlocks(streetMap().graph.vertices);
  ASSERT_GT(blocks.size(), 1u);
  blocks[1].data.resize(blocks[1].data.size() / 2);
  const StoredBlocks stored(blocks, "town.xvm");
  const auto nothing = [](std::uint32_t, const Vertex&) {};
  EXPECT_EQ(stored.at(5).points, 5u);
  for (const std::string& message : {test::messageOf<Error>([&] { stored.at(1024); }),
                                     test::messageOf<Error>([&] { stored.forAll(nothing); }),
                                     test::messageOf<Error>([&] { stored.bounds(); }),
                                     test::messageOf<Error>([&] { stored.whole(); })})
    EXPECT_EQ(message.find("town.xvm: damaged map file: "), 0u) << message;
  std::swap(blocks[0], blocks[1]);
  EXPECT_THROW(StoredBlocks(blocks, "town.xvm"), Damage);
}

}  // namespace
}  // namespace xview::map
