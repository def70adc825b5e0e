// SPDX-License-Identifier: BSD-3-Clause
#include "xview/options.h"

#include <gtest/gtest.h>

namespace xview {
namespace {

TEST(SizedOptions, LengthsThatNobodySetFollowTheSizeAndOthersStay) {
  Options options;
  options.edges.radius_m = 7;
  const Options desk = atSize(options, kDeskScale);
  EXPECT_EQ(desk.edges.radius_m, 7);
  EXPECT_EQ(desk.merge.object_m, Options().merge.object_m * kDeskScale);
  EXPECT_EQ(desk.walks.num_walks, options.walks.num_walks);
  EXPECT_EQ(desk.size, "desk");
}

TEST(SizedOptions, InLengthsOfATownOnlyWhatSomebodySetChanges) {
  Options options;
  options.edges.radius_m = 7;
  options.odometry.drift_deg_per_m = 8;
  options.prior.near = "1,-2,0.5";
  const Options desk = inCanonicalLengths(options, kDeskScale);
  EXPECT_EQ(desk.edges.radius_m, 7 * 16);
  EXPECT_EQ(desk.odometry.drift_deg_per_m, 0.5);
  EXPECT_EQ(desk.merge.object_m, Options().merge.object_m);
  EXPECT_EQ(desk.prior.near, "16,-32,8");
  EXPECT_EQ(desk.size, "town");
}

TEST(SizedOptions, ATownKeepsAllOfThem) {
  Options options;
  options.edges.radius_m = 7;
  options.prior.near = "1,2,3";
  EXPECT_EQ(inCanonicalLengths(options, kTownScale).edges.radius_m, 7);
  EXPECT_EQ(inCanonicalLengths(options, kTownScale).prior.near, "1,2,3");
  EXPECT_EQ(atSize(options, kTownScale).merge.object_m, options.merge.object_m);
}

}  // namespace
}  // namespace xview
