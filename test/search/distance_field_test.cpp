// SPDX-License-Identifier: BSD-3-Clause
#include "search/distance_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <set>

#include "base/pose.h"
#include "base/random.h"
#include "bev_town.h"

namespace xview::search {
using namespace test;
namespace {

/// The definition of a class, sample by sample.
class BruteForceField {
 public:
  explicit BruteForceField(const BevGrid& map) : map_(map) {
    const int reach = static_cast<int>(1.0 / map.cell_m);
    for (const GroundCell& c : map.known) {
      for (int dy = -reach; dy <= reach; ++dy) {
        for (int dx = -reach; dx <= reach; ++dx) {
          seen_.emplace(c.y + dy, c.x + dx);
          tiles_.emplace((c.y + dy) >> 6, (c.x + dx) >> 6);
        }
      }
    }
  }
  double distance(std::size_t channel, std::int32_t cx, std::int32_t cy) const {
    double best = std::numeric_limits<double>::infinity();
    for (const BevSample& s : map_.samples[channel]) {
      best = std::min(best,
                      std::hypot((cx + 0.5) * map_.cell_m - s.x, (cy + 0.5) * map_.cell_m - s.y));
    }
    return best;
  }
  std::uint8_t bin(double distance, std::int32_t cx, std::int32_t cy) const {
    if (!tiles_.count({cy >> 6, cx >> 6})) return kUnknownBin;
    const auto bin = static_cast<std::uint8_t>(
        std::upper_bound(kBinLimits_m.begin(), kBinLimits_m.end(), static_cast<float>(distance)) -
        kBinLimits_m.begin());
    return distance >= 2 && !seen_.count({cy, cx}) ? static_cast<std::uint8_t>(kUnknownBin) : bin;
  }

 private:
  const BevGrid& map_;
  std::set<std::pair<std::int32_t, std::int32_t>> seen_, tiles_;
};

void expectAsByBruteForce(const BevGrid& map, const DistanceField& field, int cells,
                          double extent_m, Random& random) {
  const BruteForceField oracle(map);
  int compared = 0;
  std::set<int> bins;
  for (int i = 0; i < cells; ++i) {
    const auto cx =
        static_cast<std::int32_t>(std::floor(random.uniform(-extent_m, extent_m) / map.cell_m));
    const auto cy =
        static_cast<std::int32_t>(std::floor(random.uniform(-extent_m, extent_m) / map.cell_m));
    const std::size_t c = random.below(kBevChannels);
    const double d = oracle.distance(c, cx, cy);
    const int found = field.bin(c, cx, cy);
    bins.insert(found);
    if (found == oracle.bin(d, cx, cy)) continue;
    // Sites that cells hand on to their neighbours now and then are not the nearest, by some
    // thousandths of a cell (Danielsson 1980); that may put a distance over a limit, nothing else.
    const double missed_m = 0.005 * map.cell_m;
    EXPECT_TRUE(found == oracle.bin(d - missed_m, cx, cy) ||
                found == oracle.bin(d + missed_m, cx, cy))
        << toString(static_cast<BevChannel>(c)) << " at " << cx << ' ' << cy << ": distance " << d
        << ", class " << found;
    ++compared;
  }
  EXPECT_LT(compared, cells / 100);
  EXPECT_EQ(bins.size(), static_cast<std::size_t>(kDistanceBins + 1))
      << "every class must have been tried";
}

/// Seen discs with random samples in and beside them; channels differ in density.
BevGrid randomMap(double cell_m, double extent_m, std::uint64_t seed) {
  Random random(seed);
  BevGrid map;
  map.cell_m = cell_m;
  std::set<std::pair<std::int32_t, std::int32_t>> cells;
  for (int disc = 0; disc < 6; ++disc) {
    const double x = random.uniform(-extent_m, extent_m), y = random.uniform(-extent_m, extent_m),
                 r = random.uniform(3, 20);
    for (double py = y - r; py < y + r; py += cell_m) {
      for (double px = x - r; px < x + r; px += cell_m) {
        if (std::hypot(px - x, py - y) > r || random.uniform() < 0.2) continue;
        cells.emplace(static_cast<std::int32_t>(std::floor(py / cell_m)),
                      static_cast<std::int32_t>(std::floor(px / cell_m)));
      }
    }
  }
  for (const auto& [y, x] : cells)
    map.known.push_back({x, y, static_cast<float>(0.1 * x), random.uniform() < 0.7});
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    const auto count = static_cast<int>(std::pow(10, random.uniform(0, 3.5)));
    for (int i = 0; i < count; ++i) {
      const GroundCell& cell =
          map.known[random.below(static_cast<std::uint32_t>(map.known.size()))];
      const double stray = random.uniform() < 0.1 ? 8 : 0;
      map.samples[c].push_back({static_cast<float>((cell.x + random.uniform()) * cell_m + stray),
                                static_cast<float>((cell.y + random.uniform()) * cell_m), 0});
    }
  }
  return map;
}

TEST(DistanceField, IsAsByBruteForce) {
  Random random(8);
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const BevGrid map = randomMap(0.5, 60, seed);
    expectAsByBruteForce(map, DistanceField(map), 5000, 75, random);
  }
}

TEST(DistanceField, IsAsByBruteForceForOtherCells) {
  Random random(9);
  for (const double cell_m : {0.25, 1.0}) {
    const BevGrid map = randomMap(cell_m, 40, 11);
    expectAsByBruteForce(map, DistanceField(map), 5000, 55, random);
  }
}

TEST(DistanceField, IsAsByBruteForceInATown) {
  Random random(10);
  const BevGrid map = randomTown(3).view({0, 0}, 90, Eigen::Isometry3d::Identity());
  const BruteForceField oracle(map);
  const DistanceField field(map);
  for (int i = 0; i < 4000; ++i) {
    const auto cx = static_cast<std::int32_t>(random.below(400)) - 200,
               cy = static_cast<std::int32_t>(random.below(400)) - 200;
    const std::size_t c = random.below(kBevChannels);
    const double d = oracle.distance(c, cx, cy);
    const int found = field.bin(c, cx, cy);
    EXPECT_TRUE(found == oracle.bin(d, cx, cy) || found == oracle.bin(d - 1e-4, cx, cy) ||
                found == oracle.bin(d + 1e-4, cx, cy))
        << toString(static_cast<BevChannel>(c)) << " at " << cx << ' ' << cy << ": distance " << d
        << ", class " << found;
  }
}

TEST(DistanceField, OneSampleIsSeenFromAllTilesAround) {
  for (const double x : {0.1, 31.9, -0.1, -31.9, 16.0}) {
    BevGrid map;
    for (std::int32_t cy = -80; cy < 80; ++cy) {
      for (std::int32_t cx = -80; cx < 80; ++cx) map.known.push_back({cx, cy, 0, true});
    }
    map[BevChannel::pole] = {{static_cast<float>(x), static_cast<float>(-x), 0}};
    const DistanceField field(map);
    const BruteForceField oracle(map);
    const auto c = static_cast<std::size_t>(BevChannel::pole);
    for (std::int32_t cy = -80; cy < 80; cy += 3) {
      for (std::int32_t cx = -80; cx < 80; ++cx) {
        ASSERT_EQ(field.bin(c, cx, cy), oracle.bin(oracle.distance(c, cx, cy), cx, cy))
            << x << ": " << cx << ' ' << cy;
      }
    }
  }
}

TEST(DistanceField, SamplesThatShareACellAllCount) {
  BevGrid map;
  for (std::int32_t cy = 0; cy < 64; ++cy) {
    for (std::int32_t cx = 0; cx < 64; ++cx) map.known.push_back({cx, cy, 0, true});
  }
  for (int i = 0; i < 60; ++i) {  // more than a sparse channel
    const auto y = static_cast<float>(0.5 * i + 1);
    map[BevChannel::tree].push_back({16.02f, y + 0.05f, 0});
    map[BevChannel::tree].push_back({16.48f, y + 0.25f, 0});
    map[BevChannel::tree].push_back({16.25f, y + 0.25f, 0});
  }
  const DistanceField field(map);
  const BruteForceField oracle(map);
  const auto c = static_cast<std::size_t>(BevChannel::tree);
  for (std::int32_t cy = 0; cy < 64; ++cy) {
    for (std::int32_t cx = 0; cx < 64; ++cx) {
      const double d = oracle.distance(c, cx, cy);
      const int found = field.bin(c, cx, cy);
      ASSERT_TRUE(found == oracle.bin(d - 1e-4, cx, cy) || found == oracle.bin(d + 1e-4, cx, cy))
          << cx << ' ' << cy << ' ' << d;
    }
  }
}

TEST(DistanceField, WhatWasNeverSeenIsUnknown) {
  BevGrid map;
  map.known = {{0, 0, 0, true}};
  map[BevChannel::pole] = {{0.25f, 0.25f, 0}, {40, 40, 0}};
  const DistanceField field(map);
  const auto pole = static_cast<std::size_t>(BevChannel::pole),
             sign = static_cast<std::size_t>(BevChannel::sign);
  EXPECT_EQ(field.bin(pole, 0, 0), 0);
  EXPECT_EQ(field.bin(pole, 3, 0), 4) << "1.5 m from a pole, where the map was not seen";
  EXPECT_EQ(field.bin(pole, 4, 0), kUnknownBin) << "2 m from a pole, where the map was not seen";
  EXPECT_EQ(field.bin(sign, 0, 0), kDistanceBins - 1) << "seen, and there is no sign";
  EXPECT_EQ(field.bin(sign, 2, 2), kDistanceBins - 1) << "within 1 m of a seen cell";
  EXPECT_EQ(field.bin(sign, 3, 0), kUnknownBin);
  EXPECT_EQ(field.bin(pole, 80, 80), kUnknownBin) << "no tile there, whatever stands there";
  EXPECT_EQ(field.bin(pole, -2000000, 2000000), kUnknownBin);
}

TEST(DistanceField, OfNothingHasNoTiles) {
  const DistanceField field{BevGrid()};
  EXPECT_TRUE(field.tiles().empty());
  EXPECT_EQ(field.bin(0, 0, 0), kUnknownBin);
  EXPECT_EQ(field.tileOfCell(-5, 1000), nullptr);
}

TEST(DistanceField, KeepsTheMeasuredHeights) {
  BevGrid map;
  map.known = {{-70, -1, 2.5f, true}, {5, 5, 1.5f, true}, {6, 5, 9.f, false}};
  const DistanceField field(map);
  const auto height = [&](std::int32_t x, std::int32_t y) {
    return field.tileOfCell(x, y)->ground[DistanceField::cellInTile(x, y)];
  };
  EXPECT_EQ(height(-70, -1), 2.5f);
  EXPECT_EQ(height(5, 5), 1.5f);
  EXPECT_TRUE(std::isnan(height(6, 5))) << "a guess is not a measurement";
}

TEST(DistanceField, DoesNotDependOnThreadsOrOnWhatIsAskedFirst) {
  const BevGrid map = randomMap(0.5, 60, 5);
  const DistanceField one(map), two(map);
  two.makeAll(2);
  std::vector<PlaneCell> tiles = one.tiles();
  ASSERT_EQ(tiles.size(), two.tiles().size());
  std::reverse(tiles.begin(), tiles.end());
  for (const PlaneCell& tile : tiles) {
    const auto of_one = one.tileOfCell(64 * tile.x, 64 * tile.y),
               of_two = two.tileOfCell(64 * tile.x, 64 * tile.y);
    for (std::size_t c = 0; c < kBevChannels; ++c)
      EXPECT_TRUE(std::equal(of_one->bins[c], of_one->bins[c] + 64 * 64, of_two->bins[c]));
  }
}

/// The mean of samples in a cell of 1 m is as far from them as the diagonal of the cell at most.
TEST(DistanceField, FromAfarIsNearlyTheSame) {
  const BevGrid map = randomMap(0.5, 60, 6);
  const DistanceField field(map);
  const auto binOf = [](double d) {
    return std::upper_bound(kBinLimits_m.begin(), kBinLimits_m.end(), static_cast<float>(d)) -
           kBinLimits_m.begin();
  };
  std::set<int> bins;
  for (const PlaneCell& tile : field.tiles()) {
    const std::vector<std::uint8_t> cells = field.overview(tile, 32);
    ASSERT_EQ(cells.size(), kBevChannels * 32 * 32);
    for (std::size_t i = 0; i < cells.size(); i += 7) {
      const int found = cells[i] & 15;
      ASSERT_EQ(cells[i] >> 4, found) << "one cell per square";
      bins.insert(found);
      if (found == kUnknownBin) continue;
      const double x = tile.x * 32.0 + static_cast<double>(i % 32) + 0.5,
                   y = tile.y * 32.0 + static_cast<double>(i / 32 % 32) + 0.5;
      double nearest = std::numeric_limits<double>::infinity();
      for (const BevSample& s : map.samples[i / 1024])
        nearest = std::min(nearest, std::hypot(x - s.x, y - s.y));
      EXPECT_GE(found, binOf(nearest - std::sqrt(2.0)));
      EXPECT_LE(found, binOf(nearest + std::sqrt(2.0)));
    }
  }
  EXPECT_EQ(bins.size(), static_cast<std::size_t>(kDistanceBins + 1));
  EXPECT_EQ(field.overview({500, 500}, 8)[0], kUnknownBin | kUnknownBin << 4);
}

TEST(DistanceField, FromAfarHasTheNearestAndTheMedianClass) {
  const DistanceField field(randomMap(0.5, 60, 7));
  for (const PlaneCell& tile : field.tiles()) {
    const std::vector<std::uint8_t> cells = field.overview(tile, 32),
                                    squares = field.overview(tile, 8);
    for (std::size_t i = 0; i < squares.size(); i += 3) {
      std::vector<int> bins;
      for (std::size_t k = 0; k < 16; ++k) {
        const std::size_t c = i / 64, y = i / 8 % 8 * 4 + k / 4, x = i % 8 * 4 + k % 4;
        bins.push_back(cells[c * 1024 + y * 32 + x] & 15);
      }
      std::sort(bins.begin(), bins.end());
      ASSERT_EQ(squares[i] & 15, bins.front());
      ASSERT_EQ(squares[i] >> 4, bins[7]);
    }
  }
}

/// The columns of a view, and which of them were asked for.
class ColumnsOf final : public StoredView {
 public:
  explicit ColumnsOf(const BevGrid& view) : whole_(view) {
    const auto columnOf = [](double p) { return floorToInt(p / kColumn_m); };
    for (const GroundCell& cell : view.known)
      part({columnOf(cell.x * view.cell_m), columnOf(cell.y * view.cell_m)}).known.push_back(cell);
    for (std::size_t c = 0; c < kBevChannels; ++c) {
      for (const BevSample& s : view.samples[c])
        part({columnOf(double{s.x}), columnOf(double{s.y})}).samples[c].push_back(s);
    }
  }
  std::vector<PlaneCell> columns() const override {
    std::vector<PlaneCell> all;
    for (const auto& [key, part] : parts_) all.push_back({key.second, key.first});
    return all;
  }
  std::shared_ptr<const BevGrid> partOf(const PlaneCell& column) const override {
    asked.emplace(column.y, column.x);
    const auto found = parts_.find({column.y, column.x});
    return found == parts_.end() ? std::make_shared<const BevGrid>() : found->second;
  }
  const BevGrid& whole() const override { return whole_; }
  std::size_t sampleCount() const override { return whole_.sampleCount(); }
  std::uint64_t fingerprint() const override { return fingerprintOf(whole_); }

  mutable std::multiset<std::pair<std::int32_t, std::int32_t>> asked;

 private:
  BevGrid& part(const PlaneCell& column) {
    auto& part = parts_[{column.y, column.x}];
    if (!part) part = std::make_shared<BevGrid>();
    return *part;
  }
  BevGrid whole_;
  std::map<std::pair<std::int32_t, std::int32_t>, std::shared_ptr<BevGrid>> parts_;
};

TEST(DistanceField, OfAStoredViewIsThatOfTheWholeOne) {
  for (const double cell_m : {0.5, 1.0}) {
    ASSERT_TRUE(DistanceField::fitsColumns(cell_m));
    const BevGrid map = randomMap(cell_m, 150, 8);
    const auto stored = std::make_shared<const ColumnsOf>(map);
    BevGrid grid;
    grid.cell_m = cell_m;
    const DistanceField whole(map), field(grid, stored, overviewOf(whole, 8, 1));
    ASSERT_EQ(field.tiles().size(), whole.tiles().size());
    EXPECT_TRUE(stored->asked.empty()) << "nothing is read before it is asked for";
    const PlaneCell first = field.tiles().front();
    EXPECT_EQ(field.overview(first, 8), whole.overview(first, 8));
    EXPECT_LE(stored->asked.size(), 9u);
    for (const PlaneCell& at : field.tiles()) {
      const auto a = field.tileOfCell(64 * at.x, 64 * at.y),
                 b = whole.tileOfCell(64 * at.x, 64 * at.y);
      ASSERT_NE(a, nullptr);
      ASSERT_NE(b, nullptr);
      for (std::size_t c = 0; c < kBevChannels; ++c)
        ASSERT_TRUE(std::equal(a->bins[c], a->bins[c] + 64 * 64, b->bins[c]));
      EXPECT_TRUE(a->level == b->level || (std::isnan(a->level) && std::isnan(b->level)));
      for (std::size_t i = 0; i < a->ground.size(); ++i) {
        ASSERT_TRUE(a->ground[i] == b->ground[i] ||
                    (std::isnan(a->ground[i]) && std::isnan(b->ground[i])));
      }
    }
    EXPECT_EQ(stored->asked.size(), stored->columns().size()) << "each column is read once";
    EXPECT_EQ(field.tileOfCell(100000, 0), nullptr);
  }
  EXPECT_FALSE(DistanceField::fitsColumns(0.3));
  EXPECT_FALSE(DistanceField::fitsColumns(2));
}

TEST(MapNull, IsFullerOfMatchesWhereStreetsRepeat) {
  // Ten copies of 40 m of street, and as much of a street without copies.
  Random random(4);
  BevTown same, unlike;
  same.street(-200, -165, 0, random);
  for (int i = 0; i < 3; ++i) same.repeat(40 << i, 0);
  unlike.street(-200, 115, 0, random);
  const Eigen::Isometry3d T_frame_town = poseFromYaw({0, 0, 0}, 0.7);
  std::vector<Eigen::Vector2d> path;
  for (int x = -180; x < 100; x += 40) {  // the same place of each copy
    for (int i = 0; i < 4; ++i)
      path.emplace_back((T_frame_town * Eigen::Vector3d(x + 0.5 * i, 0, 0)).head<2>());
  }
  const auto shareOfNear = [&](const BevTown& town) {
    const BevGrid map = town.view({-40, 0}, 200, T_frame_town);
    const MapNull null = mapNull(map, path, DistanceField(map)).counts;
    double near = 0, total = 0;
    for (const BevChannel c :
         {BevChannel::building, BevChannel::fence, BevChannel::pole, BevChannel::tree}) {
      const auto& counts = null[static_cast<std::size_t>(c)];
      near += counts[0] + counts[1] + counts[2] + counts[3];
      for (const double n : counts) total += n;
    }
    return near / total;
  };
  EXPECT_GT(shareOfNear(same), 1.3 * shareOfNear(unlike))
      << shareOfNear(same) << " and " << shareOfNear(unlike);
}

TEST(MapNull, OfAShortPathSaysNothing) {
  const BevGrid map = randomTown(4).view({0, 0}, 50, Eigen::Isometry3d::Identity());
  for (const auto& channel : mapNull(map, {{0, 0}, {2, 0}, {4, 0}}, DistanceField(map)).counts) {
    for (const double n : channel) EXPECT_EQ(n, 0);
  }
}

TEST(MapNull, CountsOnlyWhereTheMapWasSeen) {
  BevGrid map;
  for (std::int32_t cx = -200; cx < 200; ++cx) map.known.push_back({cx, 0, 0, true});
  for (std::int32_t cx = -200; cx < 200; ++cx)
    map[BevChannel::road].push_back({(static_cast<float>(cx) + 0.5f) / 2, 0.25f, 0});
  std::vector<Eigen::Vector2d> path;
  for (double x = -90; x < 90; x += 2) path.emplace_back(x, 0.25);
  const MapNull null = mapNull(map, path, DistanceField(map)).counts;
  const auto& road = null[static_cast<std::size_t>(BevChannel::road)];
  EXPECT_GT(road[0] + road[1] + road[2] + road[3], 1000);
  EXPECT_EQ(road[5] + road[6] + road[7] + road[8], 0)
      << "a road fits a road wherever both are seen";
}

/// A path that grows by as much as it has doubles what is counted, and says the same.
TEST(MapNull, GrowsWithItsPath) {
  const BevGrid map = randomTown(4).view({0, 0}, 150, Eigen::Isometry3d::Identity());
  const DistanceField field(map);
  std::vector<Eigen::Vector2d> path;
  for (double x = -120; x < 120; x += 2) path.emplace_back(x, 0);
  const std::vector<Eigen::Vector2d> half(path.begin(), path.begin() + 60);
  const PathNull whole = mapNull(map, path, field), first = mapNull(map, half, field);
  EXPECT_EQ(mapNull(map, path, field, first).counts, first.counts) << "it stands for this view";
  PathNull of_another = first;
  of_another.view = 0;
  const PathNull grown = mapNull(map, path, field, of_another);
  EXPECT_EQ(grown.poses, path.size());
  EXPECT_EQ(grown.view, whole.view);
  of_another.poses = path.size();
  EXPECT_EQ(mapNull(map, path, field, of_another).counts, whole.counts) << "of another view";
  const auto shareOfNear = [](const PathNull& null) {
    double near = 0, all = 0;
    for (const auto& channel : null.counts) {
      near += channel[0] + channel[1] + channel[2];
      for (const double n : channel) all += n;
    }
    EXPECT_GT(all, 1000);
    return near / all;
  };
  EXPECT_NEAR(shareOfNear(grown), shareOfNear(whole), 0.1 * shareOfNear(whole));
}

}  // namespace
}  // namespace xview::search
