// SPDX-License-Identifier: BSD-3-Clause
#include "place/bev_grid.h"

#include <gtest/gtest.h>

#include "bev_scene.h"
#include "xview/base/error.h"

namespace xview::test {

namespace {

void expectEqual(const BevGrid& a, const BevGrid& b) {
  EXPECT_EQ(a.origin_x, b.origin_x);
  EXPECT_EQ(a.origin_y, b.origin_y);
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    ASSERT_EQ(a.samples[c].size(), b.samples[c].size()) << toString(static_cast<BevChannel>(c));
    for (std::size_t i = 0; i < a.samples[c].size(); ++i) {
      EXPECT_EQ(a.samples[c][i].x, b.samples[c][i].x);
      EXPECT_EQ(a.samples[c][i].y, b.samples[c][i].y);
    }
  }
  ASSERT_EQ(a.known.size(), b.known.size());
  for (std::size_t i = 0; i < a.known.size(); ++i) {
    EXPECT_EQ(a.known[i].x, b.known[i].x);
    EXPECT_EQ(a.known[i].y, b.known[i].y);
    EXPECT_EQ(a.known[i].measured, b.known[i].measured);
  }
}

/// A view with one known cell and nothing else.
BevGrid bareView(double origin_x = 0) {
  BevGrid view;
  view.origin_x = origin_x;
  view.known.push_back({0, 0, 0, true});
  return view;
}

TEST(MergeBevGrids, WithItselfChangesNothing) {
  const BevGrid before = junction().view();
  BevGrid view = before;
  mergeBevGrids(view, before);
  expectEqual(view, before);
}

TEST(MergeBevGrids, ASecondTimeChangesNothing) {
  BevScene other;
  other.patch(Kind::road, 50, 16, 100, 24, 0.1).wall(Kind::building, 70, 30.3, 90, 30.3, 0.1, 6);
  other.column(Kind::pole, 60.2, 15.1, 0.1, 4);
  BevGrid view = junction().view();
  mergeBevGrids(view, other.view());
  const BevGrid once = view;
  mergeBevGrids(view, other.view());
  expectEqual(view, once);
}

TEST(MergeBevGrids, WithAnEmptyOneIsTheOther) {
  const BevGrid full = junction().view();
  BevGrid view = full, nothing;
  mergeBevGrids(view, BevGrid());
  expectEqual(view, full);
  mergeBevGrids(nothing, full);
  expectEqual(nothing, full);
}

TEST(MergeBevGrids, OfSeparateSightsIsTheViewOfBoth) {
  // Far enough apart for their ground heights not to touch; their origins differ by several tiles.
  BevScene west, east, both;
  for (BevScene* scene : {&west, &both}) {
    scene->patch(Kind::road, 2, 2, 20, 10, 0.0).patch(Kind::sidewalk, 12, 4, 20, 10, 0.0);
    scene->column(Kind::pole, 15.2, 5.2, 0, 4);
  }
  for (BevScene* scene : {&east, &both}) {
    scene->patch(Kind::terrain, 200, -90, 220, -80, 0.0).patch(Kind::road, 210, -84, 220, -70, 0.0);
    scene->wall(Kind::fence, 202, -79.7, 209, -75.2, 0, 2);
  }
  BevGrid view = west.view();
  const BevGrid addition = east.view();
  EXPECT_GT(addition.origin_x - view.origin_x, 100);
  mergeBevGrids(view, addition);
  const BevGrid expected = both.view();
  ASSERT_EQ(view.known.size(), expected.known.size());
  for (std::size_t c = 0; c < kBevChannels; ++c) {
    SCOPED_TRACE(toString(static_cast<BevChannel>(c)));
    ASSERT_EQ(view.samples[c].size(), expected.samples[c].size());
    for (std::size_t i = 0; i < view.samples[c].size(); ++i) {
      EXPECT_NEAR(view.samples[c][i].x, expected.samples[c][i].x, 1e-3);
      EXPECT_NEAR(view.samples[c][i].y, expected.samples[c][i].y, 1e-3);
    }
  }
}

TEST(MergeBevGrids, ShiftsSamplesCellsAndHeightsByTheOrigins) {
  BevGrid view = bareView(), addition = bareView(64);
  addition.origin_y = -128;
  addition.origin_z = 64;
  addition.known[0].z = 1;
  addition[BevChannel::fence].push_back({0.25f, 0.25f, 1.f});
  mergeBevGrids(view, addition);
  ASSERT_EQ(view.known.size(), 2u);
  EXPECT_EQ(view.known[0].x, 128);  // (y, x) order: the addition comes first
  EXPECT_EQ(view.known[0].y, -256);
  EXPECT_FLOAT_EQ(view.known[0].z, 65);
  ASSERT_EQ(view[BevChannel::fence].size(), 1u);
  EXPECT_FLOAT_EQ(view[BevChannel::fence][0].x, 64.25f);
  EXPECT_FLOAT_EQ(view[BevChannel::fence][0].y, -127.75f);
  EXPECT_FLOAT_EQ(view[BevChannel::fence][0].z, 65);
}

TEST(MergeBevGrids, ObjectsWithinAMetreAreOneOfTheirChannelOnly) {
  BevGrid view = bareView(), addition = bareView();
  view[BevChannel::pole] = {{10, 10, 0}};
  addition[BevChannel::pole] = {{10.9f, 10, 0}, {10, 11.1f, 0}, {9.2f, 9.2f, 0}};
  addition[BevChannel::sign] = {{10, 10, 0}};
  mergeBevGrids(view, addition);
  ASSERT_EQ(view[BevChannel::pole].size(), 3u)
      << "0.9 m is the same pole; 1.1 m and 1.13 m are not";
  EXPECT_EQ(view[BevChannel::sign].size(), 1u);
}

/// Of a large view only what lies around the addition is looked at.
TEST(MergeBevGrids, AnObjectBesideAllOfTheAdditionIsTheSame) {
  for (const float side : {-0.9f, 0.9f}) {
    BevGrid view = bareView(), addition = bareView();
    view[BevChannel::pole] = {{10, 10, 0}};
    view[BevChannel::tree] = {{20, 20, 0}};
    addition[BevChannel::pole] = {{10 + side, 10, 0}};
    addition[BevChannel::tree] = {{20, 20 + side, 0}};
    mergeBevGrids(view, addition);
    EXPECT_EQ(view[BevChannel::pole].size(), 1u) << side;
    EXPECT_EQ(view[BevChannel::tree].size(), 1u) << side;
  }
}

TEST(MergeBevGrids, GroundThatWasMeasuredStays) {
  BevGrid view = bareView(), addition = bareView();
  view[BevChannel::road] = {{0.25f, 0.25f, 0}};
  addition.known = {{0, 0, 9, true}, {1, 0, 5, true}};
  addition[BevChannel::sidewalk] = {{0.25f, 0.25f, 9}, {0.75f, 0.25f, 5}};
  mergeBevGrids(view, addition);
  ASSERT_EQ(view.known.size(), 2u);
  EXPECT_EQ(view.known[0].z, 0);
  EXPECT_EQ(view[BevChannel::road].size(), 1u);
  ASSERT_EQ(view[BevChannel::sidewalk].size(), 1u);
  EXPECT_FLOAT_EQ(view[BevChannel::sidewalk][0].x, 0.75f);
}

TEST(MergeBevGrids, MeasuredGroundReplacesGuessedGround) {
  BevGrid view = bareView(), addition = bareView();
  view.known[0] = {0, 0, 7, false};
  addition.known[0] = {0, 0, 2, true};
  addition[BevChannel::road] = {{0.25f, 0.25f, 2}};
  mergeBevGrids(view, addition);
  ASSERT_EQ(view.known.size(), 1u);
  EXPECT_EQ(view.known[0].z, 2);
  EXPECT_TRUE(view.known[0].measured);
  EXPECT_EQ(view[BevChannel::road].size(), 1u);
}

TEST(MergeBevGrids, UprightClassesOfBothPassesStayOnePerCell) {
  BevGrid view = bareView(), addition = bareView();
  view[BevChannel::building] = {{0.1f, 0.1f, 0}};
  addition[BevChannel::building] = {{0.4f, 0.4f, 0}, {0.6f, 0.1f, 0}};
  addition[BevChannel::fence] = {{0.2f, 0.2f, 0}};
  mergeBevGrids(view, addition);
  ASSERT_EQ(view[BevChannel::building].size(), 2u);
  EXPECT_FLOAT_EQ(view[BevChannel::building][0].x, 0.1f);
  EXPECT_FLOAT_EQ(view[BevChannel::building][1].x, 0.6f);
  EXPECT_EQ(view[BevChannel::fence].size(), 1u);
}

TEST(MergeBevGrids, OfOtherCellSizesIsRefused) {
  BevGrid view = bareView(), addition = bareView();
  addition.cell_m = 0.25;
  EXPECT_THROW(mergeBevGrids(view, addition), UsageError);
}

}  // namespace
}  // namespace xview::test
