// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <deque>
#include <numeric>

#include "search/raster.h"
#include "support/test_data.h"
#include "xview/search/scan_helpers.h"
#include "xview/types/error.h"
#include "xview/types/random.h"

namespace xview::search {
namespace {

/// Helpers in this process, which answer what they were sent when they are asked for it.
class InOneProcess final : public ScanHelpers {
 public:
  explicit InOneProcess(int count) : helpers_(static_cast<std::size_t>(count)) { shareScans(this); }
  ~InOneProcess() override { shareScans(nullptr); }
  InOneProcess(const InOneProcess&) = delete;
  InOneProcess& operator=(const InOneProcess&) = delete;

  int count() const override { return static_cast<int>(helpers_.size()); }
  void send(int helper, const std::string& request) override {
    of(helper).waiting.push_back(request);
    bytes_ += request.size();
  }
  std::string receive(int helper) override {
    Helper& asked = of(helper);
    if (asked.waiting.empty()) throw Error("helper", "was not asked");
    const std::string request = asked.waiting.front();
    asked.waiting.pop_front();
    return asked.scan.answer(request);
  }

  std::size_t tilesOf(int helper) { return of(helper).scan.tiles(); }
  std::size_t takeBytes() { return std::exchange(bytes_, 0); }
  bool isWaitedFor() const {
    return std::any_of(helpers_.begin(), helpers_.end(),
                       [](const Helper& helper) { return !helper.waiting.empty(); });
  }

 private:
  struct Helper {
    ScanHelper scan;
    std::deque<std::string> waiting;
  };
  Helper& of(int helper) { return helpers_.at(static_cast<std::size_t>(helper)); }

  std::deque<Helper> helpers_;
  std::size_t bytes_ = 0;
};

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
  for (int i = 0; i < 3; ++i) tiles.push_back(helpers.tilesOf(i));
  search();
  EXPECT_LT(10 * helpers.takeBytes(), first) << "tiles were sent again";
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(helpers.tilesOf(i), tiles[static_cast<std::size_t>(i)]);
    EXPECT_GT(helpers.tilesOf(i), 0u);
    EXPECT_LT(helpers.tilesOf(i), raster_.tiles().size()) << "a part, with a rim";
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
  EXPECT_LT(helpers.tilesOf(0), 9 * 2 * 9 * 9u);
}

TEST_F(SharedScans, WhatIsNoRequestIsRefused) {
  ScanHelper helper;
  EXPECT_THROW(helper.answer(""), Error);
  EXPECT_THROW(helper.answer("hello, how are you?"), Error);
  EXPECT_THROW(helper.answer(std::string(1000, '\xff')), Error);
}

}  // namespace
}  // namespace xview::search
