// SPDX-License-Identifier: BSD-3-Clause
#include "../../src/map/map_tiles.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <tuple>

#include "base/random.h"

namespace xview::map {
namespace {

TEST(PackedBytes, IntegersComeBackFromEndToEnd) {
  ByteWriter writer;
  const std::vector<std::int64_t> numbers{0,
                                          -1,
                                          1,
                                          -64,
                                          64,
                                          std::numeric_limits<std::int64_t>::min(),
                                          std::numeric_limits<std::int64_t>::max()};
  for (const std::int64_t n : numbers) writer.signedInteger(n);
  writer.unsignedInteger(std::numeric_limits<std::uint64_t>::max());
  ByteReader reader(writer.bytes());
  for (const std::int64_t n : numbers) EXPECT_EQ(reader.signedInteger(), n);
  EXPECT_EQ(reader.unsignedInteger(), std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(reader.remaining(), 0u);
}

TEST(PackedBytes, SmallNumbersOfEitherSignAreOneByte) {
  ByteWriter writer;
  writer.signedInteger(-64);
  writer.signedInteger(63);
  EXPECT_EQ(writer.bytes().size(), 2u);
}

TEST(PackedBytes, WhatEndsTooEarlyOrNeverIsDamage) {
  const Bytes cut{0x80}, endless(11, 0x80), nothing;
  EXPECT_THROW(ByteReader(cut).unsignedInteger(), Damage);
  EXPECT_THROW(ByteReader(endless).unsignedInteger(), Damage);
  EXPECT_THROW(ByteReader(nothing).signedInteger(), Damage);
}

TEST(PackedBytes, ABlockThatLiesAboutItsSizeIsDamage) {
  const Bytes raw(1000, 7), packed = compressed(raw);
  EXPECT_EQ(decompressed(packed), raw);
  EXPECT_EQ(decompressed(compressed({})), Bytes());
  for (const int change : {-1, 1}) {
    Bytes lying = packed;
    lying[0] = static_cast<std::uint8_t>(lying[0] + change);
    EXPECT_THROW(decompressed(lying), Damage) << change;
  }
  EXPECT_THROW(decompressed({1, 0}), Damage);
}

TEST(PackedBytes, ABlockThatIsTooSmallOrTooLargeForItsRowsIsDamageBeforeItIsUnpacked) {
  const Bytes packed = compressed(Bytes(1000, 7));
  EXPECT_EQ(decompressed(packed, 1000, 1000).size(), 1000u);
  EXPECT_THROW(decompressed(packed, 1001, 2000), Damage);
  EXPECT_THROW(decompressed(packed, 0, 999), Damage);
}

TEST(PackedRows, AreBoundedByTheSizeOfTheFileAndByWhatIsAnnounced) {
  constexpr std::uint64_t kFile = std::uint64_t{1} << 30;
  PackedRows rows(kFile);
  rows.take("points", 5, 10);
  rows.take("points", 5, 10);
  EXPECT_THROW(rows.take("points", 1, 10), Damage);
  rows.beginPart();
  rows.take("edges", 10, 10);
  PackedRows small(1000);
  small.take("points", 4u << 20, kFile);  // so many are always allowed
  EXPECT_THROW(small.take("points", 1, kFile), Damage);
  PackedRows many(2u << 20);
  many.take("points", 16u << 20, kFile);
  EXPECT_THROW(many.take("points", 1, kFile), Damage);
}

/// A regular grid is packed so well that a reader which bounds rows by bytes would refuse it.
TEST(PackedRows, NeverRefuseWhatIsWritten) {
  LabelledCloud grid;
  for (int x = 0; x < 300; ++x) {
    for (int y = 0; y < 300; ++y)
      grid.points.emplace_back(0.2F * static_cast<float>(x), 0.2F * static_cast<float>(y), 1.0F, 3);
  }
  LabelledCloud read;
  for (const Tile& tile : toTiles(grid)) {
    EXPECT_LE(tile.points, PackedRows::kMostPerByte * tile.data.size());
    appendTile(tile, read);
  }
  EXPECT_EQ(read.size(), grid.size());
}

TEST(OverviewTiles, OfOtherSizeClassOrPlaceAreRefused) {
  search::MapOverview overview;
  Bytes squares(kBevChannels * 64, search::kUnknownBin | search::kUnknownBin << 4);
  appendTile(OverviewTile{-3, 5, compressed(squares)}, overview);
  ASSERT_EQ(overview.tiles.size(), 1u);
  EXPECT_TRUE((overview.tiles[0].at == PlaneCell{-3, 5}));
  EXPECT_EQ(overview.tiles[0].squares, squares);
  EXPECT_THROW(appendTile(OverviewTile{1 << 21, 0, compressed(squares)}, overview), Damage);
  for (const int value : {search::kUnknownBin + 1, (search::kUnknownBin + 1) << 4}) {
    squares[70] = static_cast<std::uint8_t>(value);
    EXPECT_THROW(appendTile(OverviewTile{0, 0, compressed(squares)}, overview), Damage);
  }
  squares[70] = 0;
  squares.pop_back();
  EXPECT_THROW(appendTile(OverviewTile{0, 0, compressed(squares)}, overview), Damage);
  EXPECT_EQ(overview.tiles.size(), 1u);
}

std::vector<Vertex> someVertices(std::size_t count) {
  Random random(3);
  std::vector<Vertex> vertices(count);
  for (Vertex& v : vertices) {
    v.label = random.below(5);
    v.instance = random.below(4000000000);
    for (double& x : v.position) x = random.uniform(-1e4, 1e4);
    for (double& x : v.extent) x = random.uniform();
    v.sigma_m = random.uniform();
    v.observations = random.below(9);
    v.points = random.below(100000);
    v.first_frame = static_cast<std::int64_t>(random.below(100)) - 50;
    v.last_frame = std::int64_t{1} << random.below(63);
  }
  vertices[0].position.x() = std::nextafter(1.0, 2.0);
  vertices[0].sigma_m = -0.0;
  return vertices;
}

TEST(VertexBlocks, KeepEveryBit) {
  const std::vector<Vertex> vertices = someVertices(2500);
  const std::vector<VertexBlock> blocks = toBlocks(vertices);
  ASSERT_EQ(blocks.size(), 3u);
  std::vector<Vertex> read;
  for (const VertexBlock& block : blocks) appendVertices(block, read);
  ASSERT_EQ(read.size(), vertices.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    const Vertex &a = read[i], &b = vertices[i];
    EXPECT_EQ(a.position, b.position);
    EXPECT_EQ(a.extent, b.extent);
    EXPECT_EQ(std::signbit(a.sigma_m), std::signbit(b.sigma_m));
    EXPECT_EQ(std::tie(a.label, a.instance, a.sigma_m, a.observations, a.points, a.first_frame,
                       a.last_frame),
              std::tie(b.label, b.instance, b.sigma_m, b.observations, b.points, b.first_frame,
                       b.last_frame));
  }
}

TEST(VertexBlocks, ThatAreDamagedAreRefused) {
  const VertexBlock sound = toBlocks(someVertices(1000))[0];
  const auto isRefused = [](const VertexBlock& block) {
    std::vector<Vertex> read;
    try {
      appendVertices(block, read);
    } catch (const Damage&) {
      return true;
    }
    return false;
  };
  EXPECT_FALSE(isRefused(sound));
  for (const std::uint32_t count : {0u, 999u, 1001u, 1025u, 4294967295u}) {
    VertexBlock lying = sound;
    lying.vertices = count;
    EXPECT_TRUE(isRefused(lying)) << count;
  }
  VertexBlock moved = sound;
  moved.first_vertex = 1024;
  EXPECT_TRUE(isRefused(moved));
  ByteWriter large;  // a label beyond 32 bits
  large.signedInteger(std::int64_t{1} << 32);
  for (int i = 0; i < 5 + 7 * 8; ++i) large.byte(0);
  EXPECT_TRUE(isRefused({0, 1, compressed(large.bytes())}));
}

/// Many equal vertices would be packed so well that a reader which bounds them by bytes refused
/// the file.
TEST(VertexBlocks, TakeAByteForEachVertexAtLeast) {
  for (const VertexBlock& block : toBlocks(std::vector<Vertex>(3000)))
    EXPECT_GE(block.data.size(), block.vertices);
}

}  // namespace
}  // namespace xview::map
