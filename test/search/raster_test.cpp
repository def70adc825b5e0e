// SPDX-License-Identifier: BSD-3-Clause
#include "search/raster.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>

#include "base/pose.h"
#include "base/random.h"
#include "search/raster_parts.h"
#include "search/search.h"
#include "xview/base/error.h"

namespace xview::search {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// Values in a square of cells around the origin, in both signs of the coordinates.
LikelihoodRaster randomRaster(double cell_m, std::vector<std::uint8_t> background, int half,
                              int highest, Random& random) {
  LikelihoodRaster raster(cell_m, background);
  for (std::size_t channel = 0; channel < background.size(); ++channel) {
    for (int y = -half; y < half; ++y) {
      for (int x = -half; x < half; ++x) {
        if (random.uniform() < 0.2)
          raster.set(channel, x, y, static_cast<std::uint8_t>(random.below(highest + 1)));
      }
    }
  }
  return raster;
}

std::vector<RasterSample> randomSamples(int count, double radius, std::size_t channels,
                                        Random& random) {
  std::vector<RasterSample> samples;
  for (int i = 0; i < count; ++i) {
    RasterSample s;
    s.x = static_cast<float>(random.uniform(-radius, radius));
    s.y = static_cast<float>(random.uniform(-radius, radius));
    s.channel = static_cast<std::uint16_t>(random.below(static_cast<std::uint32_t>(channels)));
    samples.push_back(s);
  }
  return samples;
}

/// The score of one pose, cell by cell.
int rasterScore(const LikelihoodRaster& map, const std::vector<RasterSample>& samples,
                const PlacePose& pose) {
  check({map, samples});
  const double cell = map.cellSize(), c = std::cos(pose.yaw), s = std::sin(pose.yaw);
  const auto cellOf = [](double v) {
    return static_cast<std::int32_t>(std::floor(v + kRoundingSlack));
  };
  int score = 0;
  for (const RasterSample& q : samples) {
    const std::int32_t cx = cellOf(pose.x / cell + (c * q.x - s * q.y) / cell);
    const std::int32_t cy = cellOf(pose.y / cell + (s * q.x + c * q.y) / cell);
    score += map.at(q.channel, cx, cy) - map.background(q.channel);
  }
  return score;
}

/// The best score over all cells and a given set of headings, by asking for each.
int bruteForceBest(const LikelihoodRaster& raster, const std::vector<RasterSample>& samples,
                   int half, const std::vector<double>& yaws) {
  int best = 0;
  for (const double yaw : yaws) {
    for (int y = -half; y < half; ++y) {
      for (int x = -half; x < half; ++x) {
        const PlacePose pose{(x + 0.5) * raster.cellSize(), (y + 0.5) * raster.cellSize(), yaw, 0};
        best = std::max(best, rasterScore(raster, samples, pose));
      }
    }
  }
  return best;
}

std::vector<double> fullCircle(double wanted_step) {
  const int count = static_cast<int>(std::ceil(2 * kPi / wanted_step));
  std::vector<double> yaws;
  for (int i = 0; i < count; ++i) yaws.push_back(i * 2 * kPi / count);
  return yaws;
}

void expectSame(const std::vector<PlacePose>& a, const std::vector<PlacePose>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].x, b[i].x);
    EXPECT_EQ(a[i].y, b[i].y);
    EXPECT_EQ(a[i].yaw, b[i].yaw);
    EXPECT_EQ(a[i].score, b[i].score);
  }
}

struct Settings {
  double max_yaw_step_rad = 0.105;
  double margin_m = std::numeric_limits<double>::infinity();
  std::size_t keep_cells = 4000;
  int threads = 1;
  PlacePrior centre_prior;
};

std::vector<PlacePose> searchRaster(const LikelihoodRaster& raster,
                                    const std::vector<RasterSample>& samples,
                                    const Settings& settings,
                                    const LikelihoodRaster* coarse = nullptr) {
  RasterLevels levels{{raster, samples, settings.max_yaw_step_rad}, std::nullopt};
  if (coarse) levels.coarse.emplace(RasterLevel{*coarse, samples, settings.max_yaw_step_rad});
  levels.margin_m = settings.margin_m;
  levels.keep_cells = settings.keep_cells;
  levels.threads = settings.threads;
  levels.centre_prior = settings.centre_prior;
  return search::searchRaster(levels);
}

TEST(LikelihoodRaster, KeepsValuesOfCellsOfAnySign) {
  LikelihoodRaster raster(2.0, {7, 0});
  const std::array<std::int32_t, 7> places{0, -1, 63, 64, -64, -65, 1000000};
  std::uint8_t value = 10;
  for (const std::int32_t x : places) {
    for (const std::int32_t y : places) raster.set(1, x, y, value++);
  }
  value = 10;
  for (const std::int32_t x : places) {
    for (const std::int32_t y : places) EXPECT_EQ(raster.at(1, x, y), value++) << x << " " << y;
  }
  EXPECT_EQ(raster.at(0, 0, 0), 7);
  EXPECT_EQ(raster.at(1, 5, 5), 0);
}

TEST(LikelihoodRaster, HoldsTheOutermostCells) {
  constexpr std::int32_t kFirst = std::numeric_limits<std::int32_t>::min();
  constexpr std::int32_t kLast = std::numeric_limits<std::int32_t>::max();
  LikelihoodRaster raster(1.0, {0});
  raster.set(0, kFirst, kLast, 3);
  raster.set(0, kLast, kFirst, 4);
  EXPECT_EQ(raster.at(0, kFirst, kLast), 3);
  EXPECT_EQ(raster.at(0, kLast, kFirst), 4);
  EXPECT_EQ(raster.at(0, kFirst, kFirst), 0);
}

TEST(LikelihoodRaster, RaiseNeverLowers) {
  LikelihoodRaster raster(1.0, {5});
  raster.raise(0, 1, 1, 9);
  raster.raise(0, 1, 1, 6);
  raster.raise(0, 2, 2, 3);
  EXPECT_EQ(raster.at(0, 1, 1), 9);
  EXPECT_EQ(raster.at(0, 2, 2), 5);
}

TEST(LikelihoodRaster, UnwrittenPlaneCostsNothing) {
  LikelihoodRaster raster(1.0, {0});
  raster.set(0, 0, 0, 1);
  raster.set(0, 100000000, -100000000, 1);
  EXPECT_EQ(raster.tiles().size(), 2u);
  raster.raise(0, 5000, 5000, 0);
  EXPECT_EQ(raster.tiles().size(), 2u);
}

TEST(LikelihoodRaster, RefusesImpossibleShapes) {
  EXPECT_THROW(LikelihoodRaster(0.0, {0}), UsageError);
  EXPECT_THROW(LikelihoodRaster(std::nan(""), {0}), UsageError);
  EXPECT_THROW(LikelihoodRaster(1.0, std::vector<std::uint8_t>(4097, 0)), UsageError);
}

TEST(RasterSearch, FindsTheBestCellOfABruteForceSearch) {
  Random random(1);
  for (int trial = 0; trial < 4; ++trial) {
    const LikelihoodRaster raster = randomRaster(3.0, {0, 0, 0}, 30, 15, random);
    const std::vector<RasterSample> samples = randomSamples(25, 30, 3, random);
    Settings options;
    options.max_yaw_step_rad = 0.6;
    const std::vector<PlacePose> poses = searchRaster(raster, samples, options);
    ASSERT_FALSE(poses.empty());
    double radius = 0;
    for (const RasterSample& s : samples) radius = std::max(radius, std::hypot<double>(s.x, s.y));
    const double step = std::min(0.6, 1.2 * 3.0 / std::max(10.0, 0.7 * radius));
    EXPECT_EQ(poses.front().score, bruteForceBest(raster, samples, 50, fullCircle(step)));
  }
}

TEST(RasterSearch, ScoresAreThoseOfSinglePoses) {
  Random random(2);
  const LikelihoodRaster raster = randomRaster(0.7, {0, 3}, 40, 60, random);
  const std::vector<RasterSample> samples = randomSamples(40, 12, 2, random);
  const std::vector<PlacePose> poses = searchRaster(raster, samples, {});
  ASSERT_EQ(poses.size(), 200u);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_EQ(rasterScore(raster, samples, poses[i]), poses[i].score);
    if (i > 0) {
      EXPECT_LE(poses[i].score, poses[i - 1].score);
    }
  }
}

TEST(RasterSearch, RecoversThePoseThatTheSamplesWereDrawnFrom) {
  Random random(3);
  for (int trial = 0; trial < 6; ++trial) {
    LikelihoodRaster raster(1.0, {0, 0});
    std::vector<RasterSample> samples;
    const double yaw = random.uniform(-kPi, kPi), tx = random.uniform(-500, 500),
                 ty = random.uniform(-500, 500);
    for (int i = 0; i < 60; ++i) {
      RasterSample s = randomSamples(1, 40, 2, random).front();
      const double x = tx + std::cos(yaw) * s.x - std::sin(yaw) * s.y,
                   y = ty + std::sin(yaw) * s.x + std::cos(yaw) * s.y;
      const auto cx = static_cast<int>(std::floor(x)), cy = static_cast<int>(std::floor(y));
      for (int b = -1; b <= 1; ++b) {
        for (int a = -1; a <= 1; ++a)
          raster.raise(s.channel, cx + a, cy + b, a == 0 && b == 0 ? 15 : 8);
      }
      samples.push_back(s);
    }
    const std::vector<PlacePose> poses = searchRaster(raster, samples, {});
    ASSERT_FALSE(poses.empty());
    EXPECT_NEAR(poses[0].x, tx, 1.5);
    EXPECT_NEAR(poses[0].y, ty, 1.5);
    EXPECT_NEAR(angleDifference(poses[0].yaw, yaw), 0, 0.04);
  }
}

TEST(RasterSearch, IsTheSameForAnyNumberOfThreads) {
  Random random(4);
  const LikelihoodRaster raster = randomRaster(2.0, {0, 1, 2}, 200, 3, random);  // many ties
  const std::vector<RasterSample> samples = randomSamples(20, 40, 3, random);
  Settings options;
  options.max_yaw_step_rad = 0.5;
  options.keep_cells = 300;
  const std::vector<PlacePose> one = searchRaster(raster, samples, options);
  for (const int threads : {0, 2, 3, 7}) {
    options.threads = threads;
    expectSame(searchRaster(raster, samples, options), one);
  }
}

TEST(RasterSearch, TiesAreBrokenByPositionThenHeading) {
  LikelihoodRaster raster(1.0, {0});
  for (const int x : {70, -70, 5}) raster.set(0, x, 10, 9);
  Settings options;
  options.keep_cells = 30;
  options.max_yaw_step_rad = 1.0;
  const std::vector<PlacePose> poses = searchRaster(raster, {{0, 0, 0}}, options);
  ASSERT_GE(poses.size(), 3u);
  EXPECT_EQ(poses[0].x, -69.5);
  EXPECT_EQ(poses[0].yaw, 0);
  for (const PlacePose& pose : poses) EXPECT_EQ(pose.score, 9);
}

TEST(RasterSearch, DoesNotDependOnTheOrderOfSamples) {
  Random random(5);
  const LikelihoodRaster raster = randomRaster(1.0, {0, 0, 4}, 60, 40, random);
  std::vector<RasterSample> samples = randomSamples(50, 25, 3, random);
  const std::vector<PlacePose> poses = searchRaster(raster, samples, {});
  std::reverse(samples.begin(), samples.end());
  expectSame(searchRaster(raster, samples, {}), poses);
}

TEST(RasterSearch, UnwrittenTilesCountAsBackground) {
  LikelihoodRaster sparse(1.0, {20}), dense(1.0, {20});
  for (int y = -200; y < 200; ++y) {
    for (int x = -200; x < 200; ++x) dense.set(0, x, y, 20);
  }
  Random random(6);
  for (int i = 0; i < 30; ++i) {
    const auto x = static_cast<int>(random.below(40)) - 20,
               y = static_cast<int>(random.below(40)) - 20;
    const auto value = static_cast<std::uint8_t>(random.below(60));
    sparse.set(0, x, y, value);
    dense.set(0, x, y, value);
  }
  const std::vector<RasterSample> samples = randomSamples(15, 15, 1, random);
  expectSame(searchRaster(sparse, samples, {}), searchRaster(dense, samples, {}));
}

TEST(RasterSearch, ManySamplesOfTheHighestValueDoNotOverflow) {
  LikelihoodRaster raster(1.0, {0});
  for (int y = -12; y < 12; ++y) {
    for (int x = -12; x < 12; ++x) raster.set(0, x, y, 255);
  }
  for (const int count : {2, 256, 257, 258, 1000}) {
    const std::vector<RasterSample> samples(static_cast<std::size_t>(count), RasterSample{1, 1, 0});
    const std::vector<PlacePose> poses = searchRaster(raster, samples, {});
    ASSERT_FALSE(poses.empty());
    EXPECT_EQ(poses[0].score, 255 * count);
  }
}

TEST(RasterSearch, AQueryWiderThanATileIsFound) {
  Random random(7);
  LikelihoodRaster raster(1.0, {0, 0});
  std::vector<RasterSample> samples = randomSamples(40, 300, 2, random);
  for (const RasterSample& s : samples) {  // turned by 90 degrees about (-999.5, 2000.5)
    raster.set(s.channel, static_cast<int>(std::floor(-999.5 - s.y)),
               static_cast<int>(std::floor(2000.5 + s.x)), 15);
  }
  Settings options;
  options.centre_prior.heading = PlacePrior::Heading{kPi / 2, 0.01};
  const std::vector<PlacePose> poses = searchRaster(raster, samples, options);
  ASSERT_FALSE(poses.empty());
  EXPECT_NEAR(poses[0].x, -999.5, 1e-9);
  EXPECT_NEAR(poses[0].y, 2000.5, 1e-9);
  EXPECT_GE(poses[0].score, 15 * 38);
}

TEST(RasterSearch, NothingInNothingOut) {
  const LikelihoodRaster empty(1.0, {0, 9});
  EXPECT_TRUE(searchRaster(empty, {{1, 2, 0}}, {}).empty());
  LikelihoodRaster raster(1.0, {0});
  raster.set(0, 0, 0, 4);
  EXPECT_TRUE(searchRaster(raster, {}, {}).empty());
  EXPECT_EQ(rasterScore(raster, {}, {}), 0);
}

TEST(RasterSearch, OnlyEvidenceAgainstReturnsNothing) {
  LikelihoodRaster raster(1.0, {10});
  for (int i = 0; i < 20; ++i) raster.set(0, i, i, 3);
  EXPECT_TRUE(searchRaster(raster, {{0, 0, 0}}, {}).empty());
}

TEST(RasterSearch, RefusesImpossibleSamples) {
  LikelihoodRaster raster(1.0, {0});
  raster.set(0, 0, 0, 4);
  EXPECT_THROW(searchRaster(raster, {{0, 0, 1}}, {}), UsageError);
  EXPECT_THROW(searchRaster(raster, {{std::numeric_limits<float>::quiet_NaN(), 0, 0}}, {}),
               UsageError);
  EXPECT_THROW(searchRaster(raster, {{5000, 0, 0}}, {}), UsageError);
}

TEST(RasterSearch, PosesAreDistinct) {
  Random random(8);
  const LikelihoodRaster raster = randomRaster(2.0, {0}, 50, 15, random);
  Settings options;
  options.max_yaw_step_rad = 0.3;
  const std::vector<PlacePose> poses =
      searchRaster(raster, randomSamples(12, 10, 1, random), options);
  const double step = 2 * kPi / std::ceil(2 * kPi / 0.24);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const bool apart =
          std::hypot(poses[i].x - poses[j].x, poses[i].y - poses[j].y) >= 1.6 * 2.0 - 1e-9;
      const bool turned =
          std::abs(angleDifference(poses[i].yaw, poses[j].yaw)) >= 1.6 * step - 1e-9;
      EXPECT_TRUE(apart || turned) << i << " " << j;
    }
  }
}

TEST(RasterSearch, ThePriorRestrictsCentreAndHeading) {
  LikelihoodRaster raster(1.0, {0});
  for (const int x : {-300, 0, 300}) {
    raster.set(0, x, 0, 10);
    raster.set(0, x + 8, 0, 10);
  }
  const std::vector<RasterSample> samples{{-4, 0, 0}, {4, 0, 0}};
  Settings options;
  options.centre_prior.near = PlacePrior::Circle{310, 0, 10};
  options.centre_prior.heading = PlacePrior::Heading{kPi, 0.5};
  const std::vector<PlacePose> poses = searchRaster(raster, samples, options);
  ASSERT_FALSE(poses.empty());
  EXPECT_EQ(poses[0].score, 20);
  for (const PlacePose& pose : poses) {
    EXPECT_LE(std::hypot(pose.x - 310, pose.y), 11);
    EXPECT_LE(std::abs(angleDifference(pose.yaw, kPi)), 0.5 + 1e-9);
  }
}

TEST(RasterSearch, SparseWorldsAreSearchedCompletely) {
  Random random(12);
  for (int trial = 0; trial < 5; ++trial) {
    LikelihoodRaster raster(1.0, {0, 5, 30});
    for (int i = 0; i < 25; ++i) {
      raster.set(random.below(3), static_cast<int>(random.below(300)) - 150,
                 static_cast<int>(random.below(300)) - 150,
                 static_cast<std::uint8_t>(random.below(60)));
    }
    const std::vector<RasterSample> samples = randomSamples(40, 60, 3, random);
    Settings options;
    options.centre_prior.heading = PlacePrior::Heading{0.7, 0};
    options.keep_cells = 100;
    const std::vector<PlacePose> poses = searchRaster(raster, samples, options);
    ASSERT_FALSE(poses.empty());
    EXPECT_EQ(poses[0].score, bruteForceBest(raster, samples, 240, {0.7}));
  }
}

TEST(RasterSearch, TheMarginKeepsCentresNearContentAndLosesNothingThere) {
  Random random(13);
  LikelihoodRaster raster(1.0, {0});
  for (int i = 0; i < 200; ++i) {
    raster.set(0, static_cast<int>(random.below(100)), static_cast<int>(random.below(100)),
               static_cast<std::uint8_t>(1 + random.below(15)));
  }
  const std::vector<RasterSample> samples = randomSamples(30, 80, 1, random);
  Settings options;
  options.max_yaw_step_rad = 0.3;
  const std::vector<PlacePose> everywhere = searchRaster(raster, samples, options);
  options.margin_m = 5;
  const std::vector<PlacePose> near = searchRaster(raster, samples, options);
  ASSERT_FALSE(near.empty());
  constexpr double kSlack = 5 + 16;  // parts of 8 cells on both sides
  for (const PlacePose& pose : near) {
    EXPECT_GT(pose.y, -kSlack);
    EXPECT_LT(pose.y, 100 + kSlack);
  }
  const auto isInside = [](const PlacePose& p) {
    return p.x > 0 && p.x < 100 && p.y > 0 && p.y < 100;
  };
  const auto best_inside = std::find_if(everywhere.begin(), everywhere.end(), isInside);
  ASSERT_NE(best_inside, everywhere.end());
  EXPECT_GE(near[0].score, best_inside->score);
}

TEST(RasterSearch, TwoLevelsFindWhatTheFineSearchFinds) {
  Random random(9);
  LikelihoodRaster coarse(6.0, {0, 0}), fine(3.0, {0, 0});
  for (int i = 0; i < 3000; ++i) {
    const auto x = static_cast<int>(random.below(400)) - 200,
               y = static_cast<int>(random.below(400)) - 200;
    const auto channel = random.below(2);
    for (int b = -1; b <= 1; ++b) {
      for (int a = -1; a <= 1; ++a) {
        const std::uint8_t value = a == 0 && b == 0 ? 15 : 9;
        fine.raise(channel, x + a, y + b, value);
        coarse.raise(channel, (x + a) >> 1, (y + b) >> 1, value);
      }
    }
  }
  std::vector<RasterSample> samples;
  for (int cy = -35; cy < 5; ++cy) {
    for (int cx = 20; cx < 60; ++cx) {
      for (std::uint16_t channel = 0; channel < 2; ++channel) {
        if (fine.at(channel, cx, cy) == 15)
          samples.push_back({(cx - 39.5f) * 3, (cy + 15.5f) * 3, channel});
      }
    }
  }
  ASSERT_GT(samples.size(), 8u);
  const std::vector<PlacePose> direct = searchRaster(fine, samples, {});
  Settings options;
  options.max_yaw_step_rad = 0.2;
  const std::vector<PlacePose> poses = searchRaster(fine, samples, options, &coarse);
  ASSERT_FALSE(direct.empty());
  ASSERT_FALSE(poses.empty());
  EXPECT_NEAR(poses[0].x, 120, 4.5);
  EXPECT_NEAR(poses[0].y, -45, 4.5);
  EXPECT_GE(poses[0].score, 0.65 * direct[0].score);
  for (const PlacePose& pose : poses) EXPECT_EQ(rasterScore(fine, samples, pose), pose.score);
  options.threads = 3;
  expectSame(searchRaster(fine, samples, options, &coarse), poses);
  EXPECT_THROW(searchRaster(coarse, samples, options, &fine), UsageError);

  // A fine raster that is written where it is looked at.
  LikelihoodRaster written(3.0, {0, 0});
  std::mutex mutex;
  std::size_t cells = 0;
  RasterLevels levels{{written, samples, 0.2}, RasterLevel{coarse, samples, 0.2}};
  levels.fine.write_first = [&](std::int64_t x, std::int64_t y, std::int64_t side) {
    std::unique_lock<std::mutex> lock(mutex);
    for (std::int64_t cy = y; cy < y + side; ++cy) {
      for (std::int64_t cx = x; cx < x + side; ++cx) {
        for (std::size_t c = 0; c < 2; ++c) {
          const auto at_x = static_cast<std::int32_t>(cx), at_y = static_cast<std::int32_t>(cy);
          written.raise(c, at_x, at_y, fine.at(c, at_x, at_y));
        }
      }
    }
    cells += static_cast<std::size_t>(side * side);
    return lock;
  };
  levels.keep_cells = Settings().keep_cells;
  levels.threads = 2;
  expectSame(search::searchRaster(levels), poses);
  EXPECT_GT(cells, 0u);

  const std::size_t all = cells;
  cells = 0;
  levels.least_share = 0.6;
  const std::vector<PlacePose> best = search::searchRaster(levels);
  ASSERT_FALSE(best.empty());
  EXPECT_LT(best.size(), poses.size()) << "cells of low scores are left out";
  EXPECT_LT(cells, all) << "what lies around them is not looked at";
  expectSame({best[0]}, {poses[0]});

  levels.least_share = 0;
  const auto posesWith = [&](double clear_share, std::size_t few_cells) {
    levels.clear_share = clear_share;
    levels.few_cells = few_cells;
    return search::searchRaster(levels);
  };
  expectSame(posesWith(0.6, 0), best);
  expectSame(posesWith(0.6, levels.keep_cells), poses);
  const std::vector<PlacePose> some = posesWith(0.6, 100);
  EXPECT_GT(some.size(), best.size()) << "the first few weak ones are looked at";
  EXPECT_LT(some.size(), poses.size());
}

/// Sums by the definition.
std::vector<std::uint32_t> plainSums(const std::vector<const std::uint8_t*>& samples,
                                     std::ptrdiff_t stride, int rows) {
  std::vector<std::uint32_t> sums(static_cast<std::size_t>(rows * kBlock));
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < kBlock; ++column) {
      for (const std::uint8_t* cells : samples)
        sums[row * kBlock + column] += cells[row * stride + column];
    }
  }
  return sums;
}

TEST(RasterKernel, HitsAreThoseOfPlainSums) {
  Random random(10);
  constexpr std::ptrdiff_t kStride = 131;
  std::vector<std::uint8_t> cells(kStride * 200);
  for (std::uint8_t& cell : cells) cell = static_cast<std::uint8_t>(random.below(256));
  for (const int count : {1, 40, 257, 600}) {
    std::vector<const std::uint8_t*> samples;
    std::vector<std::uint32_t> groups;
    for (int k = 0; k < count; ++k) {
      groups.push_back(static_cast<std::uint32_t>(k));
      samples.push_back(cells.data() + random.below(130) * kStride + random.below(60));
    }
    groups.push_back(static_cast<std::uint32_t>(count));
    const int rows = 61;
    const std::vector<std::uint32_t> sums = plainSums(samples, kStride, rows);
    const std::uint32_t threshold = sums[sums.size() / 2];
    std::vector<BlockHit> expected;
    for (std::size_t i = 0; i < sums.size(); ++i) {
      if (sums[i] >= threshold) {
        expected.push_back(
            {static_cast<std::uint16_t>(i / 64), static_cast<std::uint16_t>(i % 64), sums[i]});
      }
    }
    std::vector<BlockHit> hits(64 * 64);
    hits.resize(scanBlock(
        {samples.data(), groups.data(), groups.size() - 1, kStride, rows, threshold}, hits.data()));
    ASSERT_EQ(hits.size(), expected.size());
    for (std::size_t i = 0; i < hits.size(); ++i) {
      EXPECT_EQ(hits[i].row, expected[i].row);
      EXPECT_EQ(hits[i].column, expected[i].column);
      EXPECT_EQ(hits[i].sum, expected[i].sum);
    }
  }
}

std::vector<Candidate> manyCandidates() {
  Random random(3);
  std::vector<Candidate> all;
  for (int i = 0; i < 5000; ++i)
    all.push_back({static_cast<std::int32_t>(1 + random.below(60)), i % 7, i % 50, i / 50});
  return all;
}

bool isSame(const Candidate& a, const Candidate& b) { return !(a < b) && !(b < a); }

TEST(BestCandidates, AreThoseOfSortingAllAlsoAmongEqualScores) {
  std::vector<Candidate> all = manyCandidates();
  for (const std::size_t keep : {1u, 10u, 300u, 10000u}) {
    BestCandidates best(keep), first_half(keep);
    for (std::size_t i = 0; i < all.size(); ++i) (i % 2 ? best : first_half).offer(all[i]);
    best.merge(first_half);
    const std::vector<Candidate> found = std::move(best).sorted();
    std::vector<Candidate> expected = all;
    std::sort(expected.begin(), expected.end());
    expected.resize(std::min(keep, expected.size()));
    ASSERT_EQ(found.size(), expected.size());
    EXPECT_TRUE(std::equal(found.begin(), found.end(), expected.begin(), isSame)) << keep;
  }
}

TEST(BestCandidates, ForgetsOnlyWhatIsBelowTheLeastShareOfTheBest) {
  std::vector<Candidate> all = manyCandidates();
  BestCandidates best(all.size(), 0.5);
  for (const Candidate& candidate : all) best.offer(candidate);
  const std::vector<Candidate> found = std::move(best).sorted();
  std::sort(all.begin(), all.end());
  const auto end = std::find_if(
      all.begin(), all.end(), [&](const Candidate& c) { return c.score < all.front().score / 2; });
  EXPECT_LT(found.size(), all.size());
  ASSERT_GE(found.size(), static_cast<std::size_t>(end - all.begin()));
  EXPECT_TRUE(std::equal(all.begin(), end, found.begin(), isSame));
}

TEST(BestCandidates, BelowTheThresholdIsNothingThatCouldBeAmongThem) {
  BestCandidates best(10);
  std::vector<Candidate> all = manyCandidates();
  for (const Candidate& candidate : all) best.offer(candidate);
  std::sort(all.begin(), all.end());
  EXPECT_LE(best.threshold(), all[9].score);
  EXPECT_GT(best.threshold(), 1);
}

/// A query of one sample whose true pose lies in the worst of many cells, as a step from it tells.
class QueryWithABadCell final : public FieldQuery {
 public:
  static constexpr int kCells = 20, kApart = 5;  ///< per side of a square of peaks, between them

  QueryWithABadCell() : FieldQuery(Eigen::Vector3d::Zero(), std::nullopt), raster_(1, {0}) {
    for (int y = 0; y < kCells; ++y) {
      for (int x = 0; x < kCells; ++x) raster_.set(0, kApart * x, kApart * y, 200);
    }
    raster_.set(0, 0, 0, 100);
  }
  std::size_t size() const override { return 1; }
  std::unique_ptr<FieldQuery> part(const Eigen::Vector2d& /*centre*/,
                                   double /*radius_m*/) const override {
    return std::make_unique<QueryWithABadCell>();
  }
  std::vector<Point> points() const override { return {{Eigen::Vector2d::Zero(), 1}}; }
  RasterLevels rasterLevels() const override {
    RasterLevels levels{{raster_, {RasterSample{}}}, std::nullopt};
    levels.keep_poses = 4 * kCells * kCells;
    levels.refine_poses = 10;
    return levels;
  }
  PlacePose refineLocally(const PlacePose& pose, RefinementLevel /*how*/) const override {
    PlacePose refined = pose;
    refined.score = scoreAt(pose);
    return refined;
  }
  double scoreAt(const PlacePose& pose) const override {
    return std::hypot(pose.x, pose.y) < 1 ? 50 : 20;
  }
  PlaceHypothesis describeAt(const PlacePose& pose) const override { return inMap(pose); }

 private:
  LikelihoodRaster raster_;
};

TEST(Search, PosesOfBadCellsThatAStepImprovesAreKept) {
  PlacePrior prior;
  prior.heading = {0, 0.01};
  const SearchResult result = search(QueryWithABadCell(), {prior}, {}, 1);
  ASSERT_FALSE(result.places.empty());
  EXPECT_EQ(result.places[0].score(), 50);
}

/// A query whose true pose no cell of the first raster stands for; its best one is `share` of what
/// a true one would score.
class QueryThatIsMissed final : public FieldQuery {
 public:
  explicit QueryThatIsMissed(double share)
      : FieldQuery(Eigen::Vector3d::Zero(), std::nullopt),
        share_(share),
        raster_(1, {0}),
        finer_(0.5, {0}) {
    raster_.set(0, 40, 40, 200);
    finer_.set(0, 0, 0, 200);
  }
  std::size_t size() const override { return 1; }
  std::unique_ptr<FieldQuery> part(const Eigen::Vector2d& /*centre*/,
                                   double /*radius_m*/) const override {
    return std::make_unique<QueryThatIsMissed>(share_);
  }
  std::vector<Point> points() const override { return {{Eigen::Vector2d::Zero(), 1}}; }
  RasterLevels rasterLevels() const override { return {{raster_, {RasterSample{}}}, std::nullopt}; }
  std::unique_ptr<RasterLevels> finerLevels() const override {
    return std::make_unique<RasterLevels>(RasterLevels{{finer_, {RasterSample{}}}, std::nullopt});
  }
  PlacePose refineLocally(const PlacePose& pose, RefinementLevel /*how*/) const override {
    PlacePose refined = pose;
    refined.score = scoreAt(pose);
    return refined;
  }
  double scoreAt(const PlacePose& pose) const override { return pose.x < 10 ? 100 : 100 * share_; }
  PlaceHypothesis describeAt(const PlacePose& pose) const override {
    PlaceHypothesis h = inMap(pose);
    h.expected = 100;
    return h;
  }

 private:
  double share_;
  LikelihoodRaster raster_, finer_;
};

/// Check fix for: in narrow streets another one was accepted, as the true pose lay between cells.
TEST(Search, LooksAgainInSmallerCellsWhereNothingScoresAsATruePoseWould) {
  PlacePrior prior;
  prior.heading = {0, 0.01};
  const SearchResult again = search(QueryThatIsMissed(0.5), {prior}, {}, 1),
                     once = search(QueryThatIsMissed(0.8), {prior}, {}, 1);
  ASSERT_EQ(again.places.size(), 2u);
  EXPECT_EQ(again.places[0].score(), 100);
  ASSERT_EQ(once.places.size(), 1u) << "it would take time";
  EXPECT_EQ(once.places[0].score(), 80);
}

}  // namespace
}  // namespace xview::search
