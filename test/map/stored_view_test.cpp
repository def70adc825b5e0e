// SPDX-License-Identifier: BSD-3-Clause
// The bird's-eye view of a large map, which stays packed, and its overview.
#include "base/stored_view.h"

#include <SQLiteCpp/Database.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "base/random.h"
#include "map/contents.h"
#include "map/sample_map.h"
#include "place/bev_grid.h"
#include "search/distance_field.h"
#include "support/test_data.h"
#include "xview/base/error.h"
#include "xview/map/semantic_map.h"

namespace xview::map {
namespace {

using search::DistanceField;
using search::MapOverview;
using test::isSame;
using test::sampleMap;
using test::TemporaryFolder;

/// A map of `side` x `side` tiles, each with a few seen cells and samples.
SemanticMap largeMap(int side) {
  SemanticMap map = sampleMap();
  map.size = kTownScale;
  map.bev.known.clear();
  for (auto& samples : map.bev.samples) samples.clear();
  Random random(5);
  for (int y = 0; y < 64 * side; y += 8) {
    for (int x = 0; x < 64 * side; x += 8) {
      map.bev.known.push_back({x - 640, y - 640, 0.5F, true});
      auto& samples = map.bev.samples[random.below(kBevChannels)];
      samples.push_back({static_cast<float>((x - 640 + random.uniform(0, 8)) / 2),
                         static_cast<float>((y - 640 + random.uniform(0, 8)) / 2), 1});
    }
  }
  map.null.poses = 9;
  map.null.view = search::fingerprintOf(map.bev);
  return map;
}

void expectSame(const MapOverview& a, const MapOverview& b) {
  ASSERT_EQ(a.tiles.size(), b.tiles.size());
  for (std::size_t i = 0; i < a.tiles.size(); ++i) {
    EXPECT_TRUE(a.tiles[i].at == b.tiles[i].at) << i;
    EXPECT_EQ(a.tiles[i].squares, b.tiles[i].squares) << i;
  }
}

MapOverview overviewOf(const BevGrid& bev) {
  return search::overviewOf(DistanceField(bev), MapOverview::kSide, 1);
}

/// Ground and samples of 65 m on a side, `x_m` from the origin of a map.
BevGrid additionTo(const BevGrid& map, double x_m) {
  BevGrid addition;
  addition.origin_x = map.origin_x + x_m;
  addition.origin_y = map.origin_y - 128;
  addition.origin_z = map.origin_z;
  Random random(7);
  for (int y = -100; y < 30; ++y) {
    for (int x = -60; x < 70; ++x) {
      addition.known.push_back({x, y, 0, true});
      if (random.below(40) > 0) continue;
      addition.samples[random.below(kBevChannels)].push_back(
          {static_cast<float>((x + random.uniform()) / 2),
           static_cast<float>((y + random.uniform()) / 2), 0});
    }
  }
  return addition;
}

class LargeMap : public ::testing::Test {
 protected:
  /// Rounded as a file does.
  void SetUp() override {
    saveMap(path, largeMap(21));
    SemanticMap rounded = unpacked(openMap(path));
    rounded.overview.reset();
    saveMap(path, rounded);
  }
  TemporaryFolder folder;
  const std::string path = folder / "map.xvm";
};

TEST_F(LargeMap, HasAnOverviewInItsFile) {
  const SemanticMap map = unpacked(openMap(path));
  ASSERT_NE(map.overview, nullptr);
  EXPECT_EQ(map.overview->tiles.size(), 22u * 22u) << "what was seen is grown by 1 m, to one side";
  expectSame(*map.overview, overviewOf(map.bev));

  saveMap(folder / "small.xvm", largeMap(10));
  EXPECT_EQ(unpacked(openMap(folder / "small.xvm")).overview, nullptr);
}

TEST_F(LargeMap, KeepsItsViewPackedToLocalize) {
  SemanticMap opened = openMap(path);
  const SemanticMap whole = unpacked(openMap(path));
  ASSERT_NE(opened.stored_view, nullptr);
  EXPECT_TRUE(hasView(opened));
  EXPECT_TRUE(opened.bev.known.empty());
  EXPECT_EQ(opened.bev.sampleCount(), 0u);
  std::size_t known = 0, samples = 0;
  for (const PlaneCell& column : opened.stored_view->columns()) {
    const auto part = opened.stored_view->partOf(column);
    known += part->known.size();
    samples += part->sampleCount();
    for (const GroundCell& cell : part->known) {
      EXPECT_EQ(cell.x >> 7, column.x);
      EXPECT_EQ(cell.y >> 7, column.y);
    }
  }
  EXPECT_EQ(known, whole.bev.known.size());
  EXPECT_EQ(samples, whole.bev.sampleCount());
  EXPECT_TRUE(opened.stored_view->partOf({1000, 1000})->known.empty());
  EXPECT_TRUE(isSame(viewOf(opened), whole.bev));
  saveMap(folder / "again.xvm", opened);
  EXPECT_TRUE(isSame(unpacked(openMap(folder / "again.xvm")), whole)) << "nothing is lost";
  unpackView(opened);
  EXPECT_EQ(opened.stored_view, nullptr);
  EXPECT_TRUE(isSame(opened.bev, whole.bev));
}

TEST_F(LargeMap, WhoseWrongPlacesWereCountedOnAnotherViewIsUnpacked) {
  SemanticMap map = unpacked(openMap(path));
  ++map.null.view;
  saveMap(path, map);
  EXPECT_EQ(openMap(path).stored_view, nullptr);
  EXPECT_TRUE(isSame(openMap(path).bev, map.bev));
}

TEST_F(LargeMap, ThatChangesHasTheOverviewOfWhatItIs) {
  for (const int change : {0, 1, 2}) {
    SemanticMap map = unpacked(openMap(path));
    const MapOverview before = *map.overview;
    if (change == 0) {  // next to the corner of a column
      map.bev[BevChannel::pole].push_back({64.2F, 128.3F, 0});
    } else if (change == 1) {  // new ground, far away
      map.bev.known.push_back({5000, 5000, 0, true});
    } else {  // a column that is gone
      const auto isGone = [](double x, double y) { return x >= 0 && x < 64 && y >= 0 && y < 64; };
      auto& known = map.bev.known;
      known.erase(std::remove_if(known.begin(), known.end(),
                                 [&](const GroundCell& c) { return isGone(0.5 * c.x, 0.5 * c.y); }),
                  known.end());
      for (auto& samples : map.bev.samples) {
        samples.erase(std::remove_if(samples.begin(), samples.end(),
                                     [&](const BevSample& s) { return isGone(s.x, s.y); }),
                      samples.end());
      }
    }
    saveMap(folder / "changed.xvm", map);
    const SemanticMap changed = unpacked(openMap(folder / "changed.xvm"));
    ASSERT_NE(changed.overview, nullptr);
    expectSame(*changed.overview, overviewOf(changed.bev));
    const auto squaresOf = [](const MapOverview& overview) {
      std::size_t sum = 0;
      for (const auto& tile : overview.tiles) {
        for (const std::uint8_t square : tile.squares) sum = 31 * sum + square;
      }
      return sum;
    };
    EXPECT_NE(squaresOf(*changed.overview), squaresOf(before)) << change;
  }
  SemanticMap map = unpacked(openMap(path));
  map.bev.known.resize(map.bev.known.size() / 2);
  saveMap(folder / "half.xvm", map);
  EXPECT_EQ(unpacked(openMap(folder / "half.xvm")).overview, nullptr) << "no longer large";
}

TEST_F(LargeMap, ThatGrowsIsSeenFromAfarAnewWhereItGrew) {
  SemanticMap map = unpacked(openMap(path));
  ASSERT_TRUE(hasOverview(map));
  const MapOverview before = *map.overview;
  for (const double x_m : {0.0, 300.0, -2000.0}) {  // over what is there, at its rim, far away
    const BevGrid addition = additionTo(map.bev, x_m);
    BevGrid grown = map.bev;
    mergeBevGrids(grown, addition);
    const auto again = search::grownOverview(before, grown, addition);
    const auto anew = search::overviewOfLarge(grown);
    expectSame(*again, *anew);
    EXPECT_EQ(again->checksum, anew->checksum);
    EXPECT_GE(again->tiles.size(), before.tiles.size());
  }
  map.bev[BevChannel::pole].push_back({1, 1, 0});
  EXPECT_FALSE(hasOverview(map)) << "that of another view";
}

TEST_F(LargeMap, GrowsPackedToWhatItGrowsToUnpacked) {
  for (const double x_m : {0.0, 63.5, 300.0}) {  // the last one at its rim
    SemanticMap packed = openMap(path), whole = unpacked(openMap(path));
    const BevGrid addition = additionTo(packed.bev, x_m);
    for (SemanticMap* map : {&packed, &whole}) growView(addition, *map);
    ASSERT_NE(packed.stored_view, nullptr);
    ASSERT_EQ(whole.stored_view, nullptr);
    EXPECT_GT(whole.bev.sampleCount(), unpacked(openMap(path)).bev.sampleCount());
    EXPECT_EQ(packed.stored_view->sampleCount(), whole.bev.sampleCount());
    EXPECT_EQ(fingerprintOfView(packed), search::fingerprintOf(whole.bev));
    expectSame(*packed.overview, *whole.overview);
    packed.null.view = whole.null.view = fingerprintOfView(packed);
    saveMap(folder / "packed.xvm", packed);
    saveMap(folder / "whole.xvm", whole);
    EXPECT_EQ(test::readText(folder / "packed.xvm"), test::readText(folder / "whole.xvm"));
    EXPECT_NE(openMap(folder / "packed.xvm").stored_view, nullptr);
    EXPECT_TRUE(
        isSame(unpacked(openMap(folder / "packed.xvm")), unpacked(openMap(folder / "whole.xvm"))));
  }
}

TEST_F(LargeMap, ThatGrowsWhereNothingWasIsUnpacked) {
  SemanticMap packed = openMap(path), whole = unpacked(openMap(path));
  const BevGrid addition = additionTo(packed.bev, -2000);
  for (SemanticMap* map : {&packed, &whole}) growView(addition, *map);
  EXPECT_EQ(packed.stored_view, nullptr);
  EXPECT_TRUE(isSame(packed.bev, whole.bev));
}

TEST_F(LargeMap, IsUnpackedOnlyWhereItIsAskedFor) {
  const SemanticMap packed = openMap(path), whole = unpacked(openMap(path));
  const Eigen::Vector2d low(whole.bev.origin_x - 10, whole.bev.origin_y - 60);
  const Eigen::AlignedBox2d box(low, low + Eigen::Vector2d(90, 70));
  const auto part = viewWithin(box, packed);
  const auto isIn = [&](const BevSample& s) {
    return box.contains(
        Eigen::Vector2d(whole.bev.origin_x + double{s.x}, whole.bev.origin_y + double{s.y}));
  };
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    std::vector<BevSample> expected, found;
    for (const BevSample& s : whole.bev.samples[c]) {
      if (isIn(s)) expected.push_back(s);
    }
    for (const BevSample& s : part->samples[c]) {
      if (isIn(s)) found.push_back(s);
    }
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_EQ(found[i].x, expected[i].x);
      EXPECT_EQ(found[i].y, expected[i].y);
    }
  }
  EXPECT_LT(part->known.size(), whole.bev.known.size() / 10);
  EXPECT_EQ(viewWithin(box, whole).get(), &whole.bev);
}

TEST_F(LargeMap, CountsAtWrongPlacesAreThoseOfTheWholeView) {
  const SemanticMap packed = openMap(path), whole = unpacked(openMap(path));
  const DistanceField field(whole.bev);
  std::vector<Eigen::Vector2d> way;
  for (double x = -300; x < 300; x += 4) way.emplace_back(x, 0.3 * x);
  const search::PathNull of_whole = search::mapNull(whole.bev, way, field),
                         of_packed =
                             search::mapNull(packed.bev, way, field, {}, packed.stored_view.get());
  EXPECT_EQ(of_packed.counts, of_whole.counts);
  EXPECT_EQ(of_packed.view, of_whole.view);
  double counted = 0;
  for (const auto& channel : of_whole.counts) {
    for (const double count : channel) counted += count;
  }
  EXPECT_GT(counted, 1000);
}

}  // namespace
}  // namespace xview::map
