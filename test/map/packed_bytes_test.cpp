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

}  // namespace
}  // namespace xview::map
