// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>

#include "base/random.h"
#include "io/graph_files.h"
#include "small_files.h"
#include "support/test_data.h"
#include "xview/base/error.h"
#include "xview/io/cloud_files.h"

namespace xview::io {
namespace {

using test::raw;

constexpr int kVariantsPerSeedFile = 350;

std::string point(float x, std::uint32_t label) {
  return raw(x) + raw(2.0f) + raw(3.0f) + raw(label);
}

const std::string kPcdHeader =
    "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z label\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 "
    "1\nWIDTH 3\nHEIGHT 1\n"
    "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA ";
const std::string kPlyElements =
    "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty uint label\n"
    "element face 1\nproperty list uchar int vertex_indices\nelement edge 2\nproperty int vertex1\n"
    "property int vertex2\nend_header\n";

struct SeedFile {
  std::string name;
  std::string bytes;
};

std::vector<SeedFile> seedFiles() {
  const std::string points = point(1, 7) + point(4, 8) + point(5, 300);
  // Three points field by field: 12 bytes each, as literals and copies.
  const std::string packed = std::string("\x0B", 1) + raw(1.0f) + raw(4.0f) + raw(5.0f) +
                             std::string("\x03", 1) + raw(2.0f) + std::string("\xC0\x03", 2) +
                             std::string("\x03", 1) + raw(3.0f) + std::string("\xC0\x03", 2) +
                             std::string("\x0B", 1) + raw(7u) + raw(8u) + raw(300u);
  const std::string block =
      raw(static_cast<std::uint32_t>(packed.size())) + raw(std::uint32_t{48}) + packed;
  const std::string ply_binary =
      points + raw(std::uint8_t{3}) + raw(0) + raw(1) + raw(2) + raw(0) + raw(1) + raw(1) + raw(2);
  std::string big = point(1, 7) + point(4, 8) + point(5, 300);
  for (std::size_t i = 0; i < big.size(); i += 4) {
    std::reverse(big.begin() + static_cast<std::ptrdiff_t>(i),
                 big.begin() + static_cast<std::ptrdiff_t>(i + 4));
  }
  const auto bigInt = [](std::uint8_t last) {
    return std::string(3, '\0') + static_cast<char>(last);
  };
  big += raw(std::uint8_t{3}) + bigInt(0) + bigInt(1) + bigInt(2) + bigInt(0) + bigInt(1) +
         bigInt(1) + bigInt(2);
  return {{"ascii.pcd", kPcdHeader + "ascii\n1 2 3 7\n4.5e0 2 3 8\nnan 2 3 300\n"},
          {"binary.pcd", kPcdHeader + "binary\n" + points},
          {"packed.pcd", kPcdHeader + "binary_compressed\n" + block},
          {"ascii.ply", "ply\nformat ascii 1.0\n" + kPlyElements +
                            "1 2 3 7\n4 2 3 8\n5 2 3 300\n3 0 1 2\n0 1\n1 2\n"},
          {"little.ply", "ply\nformat binary_little_endian 1.0\n" + kPlyElements + ply_binary},
          {"big.ply", "ply\nformat binary_big_endian 1.0\n" + kPlyElements + big}};
}

std::string mutated(std::string bytes, Random& random) {
  const auto anywhere = [&] { return random.below(static_cast<std::uint32_t>(bytes.size())); };
  switch (random.below(6)) {
    case 0:
      return bytes.substr(0, anywhere());
    case 1:
      return bytes.erase(anywhere(), 1 + random.below(8));
    case 2:
      return bytes.insert(anywhere(), bytes.substr(anywhere(), 1 + random.below(30)));
    case 3: {  // another number: sizes, counts and coordinates that lie
      const std::size_t digit = bytes.find_first_of("0123456789", anywhere());
      if (digit == std::string::npos) return bytes;
      static const char* const kNumbers[] = {"0",   "-1",  "4294967295", "99999999999999999999",
                                             "1e9", "nan", "",           "2.5"};
      return bytes.replace(digit, 1, kNumbers[random.below(8)]);
    }
    default:
      for (std::uint32_t flips = 1 + random.below(4); flips > 0; --flips) {
        bytes[anywhere()] ^= static_cast<char>(1 << random.below(8));
      }
      return bytes;
  }
}

/// True if the call returned or threw an Error in one printable line.
template <class Call>
::testing::AssertionResult survives(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    const std::string what = error.what();
    const bool printable =
        std::all_of(what.begin(), what.end(), [](char c) { return c >= ' ' && c <= '~'; });
    if (!printable) return ::testing::AssertionFailure() << "unprintable message: " << what;
  } catch (const std::exception& other) {
    return ::testing::AssertionFailure() << other.what();
  }
  return ::testing::AssertionSuccess();
}

TEST(MutatedFiles, TheSeedsThemselvesLoad) {
  const test::TemporaryFolder folder;
  for (const SeedFile& seed : seedFiles()) {
    test::writeText(folder / seed.name, seed.bytes);
    const LabelledCloud cloud = readCloud(folder / seed.name);
    EXPECT_EQ(cloud.size(), seed.name == "ascii.pcd" ? 2u : 3u) << seed.name;
    EXPECT_EQ(cloud.points[0].label, 7u) << seed.name;
    EXPECT_EQ(cloud.points[1].label, 8u) << seed.name;
    EXPECT_EQ(cloud.position(1).y(), 2) << seed.name;
    EXPECT_EQ(cloud.position(1).z(), 3) << seed.name;
  }
}

TEST(MutatedFiles, EndInACloudOrAnError) {
  const test::TemporaryFolder folder;
  for (const SeedFile& seed : seedFiles()) {
    for (int i = 0; i < kVariantsPerSeedFile; ++i) {
      Random random(7, static_cast<std::uint64_t>(i));
      const std::string path = folder / seed.name;
      test::writeText(path, mutated(seed.bytes, random));
      SCOPED_TRACE(seed.name + " variant " + std::to_string(i));
      ASSERT_TRUE(survives([&] { readCloud(path); }));
      ASSERT_TRUE(survives([&] { readCloudHeader(path); }));
      if (seed.name.find(".ply") != std::string::npos) {
        ASSERT_TRUE(survives([&] { readGraph(path); }));
      }
    }
  }
}

TEST(MutatedFiles, EveryTruncationOfABinaryFileIsAnError) {
  const test::TemporaryFolder folder;
  for (const SeedFile& seed : seedFiles()) {
    if (seed.name.find("ascii") != std::string::npos) continue;  // "30" is a truncated "300"
    for (std::size_t bytes = 0; bytes < seed.bytes.size(); ++bytes) {
      test::writeText(folder / seed.name, seed.bytes.substr(0, bytes));
      ASSERT_NE(test::messageOf<Error>([&] { readCloud(folder / seed.name); }), "")
          << seed.name << " at " << bytes;
    }
  }
}

}  // namespace
}  // namespace xview::io
