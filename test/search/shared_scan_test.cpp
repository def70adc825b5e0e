// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <numeric>

#include "base/random.h"
#include "search/raster.h"
#include "search/scan_helper.h"
#include "support/helpers_in_one_process.h"
#include "support/test_data.h"
#include "xview/base/error.h"

namespace xview::search {
namespace {

using InOneProcess = test::HelpersInOneProcess<ScanHelper>;

class SharedScans : public testing::Test {
 protected:
  SharedScans() {
    for (int i = 0; i < 1500; ++i) {
      const auto channel = random_.below(2);
      raster_.set(channel, coordinate(), coordinate(),
                  static_cast<std::uint8_t>(random_.below(200)));
    }
    for (int i = 0; i < 40; ++i) {
      RasterSample sample;
      sample.x = static_cast<float>(random_.uniform(-15, 15));
      sample.y = static_cast<float>(random_.uniform(-15, 15));
      sample.channel = static_cast<std::uint16_t>(random_.below(2));
      samples_.push_back(sample);
    }
  }
  std::int32_t coordinate() { return static_cast<std::int32_t>(random_.below(500)) - 250; }

  std::vector<PlacePose> search(int threads = 1, const PlacePrior& prior = {}) const {
    RasterLevels levels{{raster_, samples_}, std::nullopt};
    levels.keep_cells = 300;
    levels.keep_poses = 40;
    levels.threads = threads;
    levels.centre_prior = prior;
    return searchRaster(levels);
  }
  static void expectSame(const std::vector<PlacePose>& a, const std::vector<PlacePose>& b) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(std::make_tuple(a[i].x, a[i].y, a[i].yaw, a[i].score),
                std::make_tuple(b[i].x, b[i].y, b[i].yaw, b[i].score))
          << i;
    }
  }

  Random random_{3};
  LikelihoodRaster raster_{2, {7, 0}};
  std::vector<RasterSample> samples_;
};

TEST_F(SharedScans, FindWhatOneProcessFinds) {
  PlacePrior prior;
  prior.near = PlacePrior::Circle{100, -200, 120};
  prior.heading = PlacePrior::Heading{1, 0.3};
  const auto alone = search(), near = search(1, prior);
  ASSERT_GT(alone.size(), 20u);
  ASSERT_GT(near.size(), 5u);
  for (const int count : {1, 2, 3, 7}) {
    InOneProcess helpers(count);
    expectSame(search(), alone);
    expectSame(search(2), alone);
    expectSame(search(1, prior), near);
    EXPECT_FALSE(helpers.isWaitedFor());
  }
  expectSame(search(), alone);
}

TEST_F(SharedScans, GiveEachHelperItsPartOnce) {
  InOneProcess helpers(3);
  search();
  const std::size_t first = helpers.takeBytes();
  std::vector<std::size_t> tiles;
  for (int i = 0; i < 3; ++i) tiles.push_back(helpers[i].tiles());
  search();
  EXPECT_LT(10 * helpers.takeBytes(), first) << "tiles were sent again";
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(helpers[i].tiles(), tiles[static_cast<std::size_t>(i)]);
    EXPECT_GT(helpers[i].tiles(), 0u);
    EXPECT_LT(helpers[i].tiles(), raster_.tiles().size()) << "a part, with a rim";
  }
}

TEST_F(SharedScans, OfManyRastersTheLastAreKept) {
  InOneProcess helpers(1);
  std::vector<LikelihoodRaster> others;
  for (int i = 0; i < 12; ++i) {
    others.emplace_back(2, std::vector<std::uint8_t>{7, 0});
    for (int k = 0; k < 50; ++k) others.back().set(0, coordinate(), coordinate(), 100);
  }
  const auto alone = search();
  for (int round = 0; round < 2; ++round) {
    for (const LikelihoodRaster& other : others) searchRaster({{other, samples_}, std::nullopt});
    expectSame(search(), alone);
  }
  EXPECT_LT(helpers[0].tiles(), 9 * 2 * 9 * 9u);
}

TEST_F(SharedScans, WhatIsNoRequestIsRefused) {
  ScanHelper helper;
  EXPECT_THROW(helper.answer(""), Error);
  EXPECT_THROW(helper.answer("hello, how are you?"), Error);
  EXPECT_THROW(helper.answer(std::string(1000, '\xff')), Error);
}

}  // namespace
}  // namespace xview::search
