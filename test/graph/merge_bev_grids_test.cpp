// SPDX-License-Identifier: BSD-3-Clause
#include "xview/graph/bev_grid.h"

#include <gtest/gtest.h>

#include "bev_scene.h"
#include "xview/types/error.h"

namespace xview::test {

using namespace graph;

namespace {

void expectEqual(const PlanView& a, const PlanView& b) {
  EXPECT_EQ(a.origin_x, b.origin_x);
  EXPECT_EQ(a.origin_y, b.origin_y);
  for (std::size_t c = 0; c < kChannels; ++c) {
    ASSERT_EQ(a.samples[c].size(), b.samples[c].size()) << toString(static_cast<Channel>(c));
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
PlanView bareView(double origin_x = 0) {
  PlanView view;
  view.origin_x = origin_x;
  view.known.push_back({0, 0, 0, true});
  return view;
}

TEST(MergePlanViews, WithItselfChangesNothing) {
  const PlanView before = junction().view();
  PlanView view = before;
  mergePlanViews(view, before);
  expectEqual(view, before);
}

TEST(MergePlanViews, ASecondTimeChangesNothing) {
  PlanScene other;
  other.patch(Kind::road, 50, 16, 100, 24, 0.1).wall(Kind::building, 70, 30.3, 90, 30.3, 0.1, 6);
  other.column(Kind::pole, 60.2, 15.1, 0.1, 4);
  PlanView view = junction().view();
  mergePlanViews(view, other.view());
  const PlanView once = view;
  mergePlanViews(view, other.view());
  expectEqual(view, once);
}

TEST(MergePlanViews, WithAnEmptyOneIsTheOther) {
  const PlanView full = junction().view();
  PlanView view = full, nothing;
  mergePlanViews(view, PlanView());
  expectEqual(view, full);
  mergePlanViews(nothing, full);
  expectEqual(nothing, full);
}

TEST(MergePlanViews, OfSeparateSightsIsTheViewOfBoth) {
  // Far enough apart for their ground heights not to touch; their origins differ by several tiles.
  PlanScene west, east, both;
  for (PlanScene* scene : {&west, &both}) {
    scene->patch(Kind::road, 2, 2, 20, 10, 0.0).patch(Kind::sidewalk, 12, 4, 20, 10, 0.0);
    scene->column(Kind::pole, 15.2, 5.2, 0, 4);
  }
  for (PlanScene* scene : {&east, &both}) {
    scene->patch(Kind::terrain, 200, -90, 220, -80, 0.0).patch(Kind::road, 210, -84, 220, -70, 0.0);
    scene->wall(Kind::fence, 202, -79.7, 209, -75.2, 0, 2);
  }
  PlanView view = west.view();
  const PlanView addition = east.view();
  EXPECT_GT(addition.origin_x - view.origin_x, 100);
  mergePlanViews(view, addition);
  const PlanView expected = both.view();
  ASSERT_EQ(view.known.size(), expected.known.size());
  for (std::size_t c = 0; c < kChannels; ++c) {
    SCOPED_TRACE(toString(static_cast<Channel>(c)));
    ASSERT_EQ(view.samples[c].size(), expected.samples[c].size());
    for (std::size_t i = 0; i < view.samples[c].size(); ++i) {
      EXPECT_NEAR(view.samples[c][i].x, expected.samples[c][i].x, 1e-3);
      EXPECT_NEAR(view.samples[c][i].y, expected.samples[c][i].y, 1e-3);
    }
  }
}

TEST(MergePlanViews, ShiftsSamplesCellsAndHeightsByTheOrigins) {
  PlanView view = bareView(), addition = bareView(64);
  addition.origin_y = -128;
  addition.origin_z = 64;
  addition.known[0].z = 1;
  addition[Channel::fence].push_back({0.25f, 0.25f, 1.f});
  mergePlanViews(view, addition);
  ASSERT_EQ(view.known.size(), 2u);
  EXPECT_EQ(view.known[0].x, 128);  // (y, x) order: the addition comes first
  EXPECT_EQ(view.known[0].y, -256);
  EXPECT_FLOAT_EQ(view.known[0].z, 65);
  ASSERT_EQ(view[Channel::fence].size(), 1u);
  EXPECT_FLOAT_EQ(view[Channel::fence][0].x, 64.25f);
  EXPECT_FLOAT_EQ(view[Channel::fence][0].y, -127.75f);
  EXPECT_FLOAT_EQ(view[Channel::fence][0].z, 65);
}

TEST(MergePlanViews, ObjectsWithinAMetreAreOneOfTheirChannelOnly) {
  PlanView view = bareView(), addition = bareView();
  view[Channel::pole] = {{10, 10, 0}};
  addition[Channel::pole] = {{10.9f, 10, 0}, {10, 11.1f, 0}, {9.2f, 9.2f, 0}};
  addition[Channel::sign] = {{10, 10, 0}};
  mergePlanViews(view, addition);
  ASSERT_EQ(view[Channel::pole].size(), 3u) << "0.9 m is the same pole; 1.1 m and 1.13 m are not";
  EXPECT_EQ(view[Channel::sign].size(), 1u);
}

TEST(MergePlanViews, GroundThatWasMeasuredStays) {
  PlanView view = bareView(), addition = bareView();
  view[Channel::road] = {{0.25f, 0.25f, 0}};
  addition.known = {{0, 0, 9, true}, {1, 0, 5, true}};
  addition[Channel::sidewalk] = {{0.25f, 0.25f, 9}, {0.75f, 0.25f, 5}};
  mergePlanViews(view, addition);
  ASSERT_EQ(view.known.size(), 2u);
  EXPECT_EQ(view.known[0].z, 0);
  EXPECT_EQ(view[Channel::road].size(), 1u);
  ASSERT_EQ(view[Channel::sidewalk].size(), 1u);
  EXPECT_FLOAT_EQ(view[Channel::sidewalk][0].x, 0.75f);
}

TEST(MergePlanViews, MeasuredGroundReplacesGuessedGround) {
  PlanView view = bareView(), addition = bareView();
  view.known[0] = {0, 0, 7, false};
  addition.known[0] = {0, 0, 2, true};
  addition[Channel::road] = {{0.25f, 0.25f, 2}};
  mergePlanViews(view, addition);
  ASSERT_EQ(view.known.size(), 1u);
  EXPECT_EQ(view.known[0].z, 2);
  EXPECT_TRUE(view.known[0].measured);
  EXPECT_EQ(view[Channel::road].size(), 1u);
}

TEST(MergePlanViews, UprightClassesOfBothPassesStayOnePerCell) {
  PlanView view = bareView(), addition = bareView();
  view[Channel::building] = {{0.1f, 0.1f, 0}};
  addition[Channel::building] = {{0.4f, 0.4f, 0}, {0.6f, 0.1f, 0}};
  addition[Channel::fence] = {{0.2f, 0.2f, 0}};
  mergePlanViews(view, addition);
  ASSERT_EQ(view[Channel::building].size(), 2u);
  EXPECT_FLOAT_EQ(view[Channel::building][0].x, 0.1f);
  EXPECT_FLOAT_EQ(view[Channel::building][1].x, 0.6f);
  EXPECT_EQ(view[Channel::fence].size(), 1u);
}

TEST(MergePlanViews, OfOtherCellSizesIsRefused) {
  PlanView view = bareView(), addition = bareView();
  addition.cell_m = 0.25;
  EXPECT_THROW(mergePlanViews(view, addition), UsageError);
}

}  // namespace
}  // namespace xview::test
