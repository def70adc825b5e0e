// SPDX-License-Identifier: BSD-3-Clause
#include "../../src/map/map_tiles.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>

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

}  // namespace
}  // namespace xview::map
