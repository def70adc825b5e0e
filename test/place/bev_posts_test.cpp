// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "bev_scene.h"

namespace xview::test {
namespace {

TEST(BevPole, IsOnePeakUnderSmearAlongTheRay) {
  BevScene scene;
  scene.patch(Kind::road, 0, 0, 20, 20, 0.0);
  scene.column(Kind::pole, 10.2, 10.2, 0, 5).column(Kind::pole, 10.3, 10.3, 0, 5);
  for (double d = 0.4; d < 2.0; d += 0.2)
    scene.column(Kind::pole, 10.2 + d, 10.2 + 0.3 * d, 1, 2.5);
  const BevGrid view = scene.view();
  for (const BevChannel channel : {BevChannel::pole, BevChannel::pole_like}) {
    ASSERT_EQ(view[channel].size(), 1u) << toString(channel);
    EXPECT_LT(distanceTo(view, channel, 10.25, 10.25), 0.5) << toString(channel);
  }
  EXPECT_TRUE(view[BevChannel::sign].empty());
}

TEST(BevPole, AWeakerPeakAMetreAwayIsTheSamePole) {
  BevScene scene;
  scene.patch(Kind::road, 0, 0, 20, 20, 0.0);
  scene.column(Kind::pole, 10.2, 10.2, 0, 5).column(Kind::pole, 11.2, 10.2, 0, 3);
  const BevGrid view = scene.view();
  ASSERT_EQ(view[BevChannel::pole].size(), 1u);
  EXPECT_LT(distanceTo(view, BevChannel::pole, 10.2, 10.2), 0.05);
}

TEST(BevPole, TwoThatStandTwoAndAHalfMetresApartAreTwo) {
  BevScene scene;
  scene.patch(Kind::road, 0, 0, 20, 20, 0.0);
  scene.column(Kind::pole, 8.2, 10.2, 0, 5).column(Kind::pole, 10.7, 10.2, 0, 5);
  const BevGrid view = scene.view();
  ASSERT_EQ(view[BevChannel::pole].size(), 2u);
  EXPECT_LT(distanceTo(view, BevChannel::pole, 8.2, 10.2), 0.05);
  EXPECT_LT(distanceTo(view, BevChannel::pole, 10.7, 10.2), 0.05);
}

TEST(BevPole, IsNotBelievedFromFarAway) {
  BevScene scene;
  scene.patch(Kind::road, 0, 0, 20, 20, 0.0);
  for (double z = 0.1; z < 5; z += 0.2) scene.point(Kind::sign, 10.2, 10.2, z, 1, false);
  const BevGrid view = scene.view();
  EXPECT_TRUE(view[BevChannel::sign].empty());
  EXPECT_TRUE(view[BevChannel::pole_like].empty());
  EXPECT_FALSE(view[BevChannel::obstacle_low].empty());
}

TEST(BevPole, InsideAHouseIsAWrongLabel) {
  BevScene scene;
  scene.patch(Kind::road, 0, 0, 20, 8, 0.0).wall(Kind::building, 0, 10.2, 20, 10.2, 0, 9);
  scene.column(Kind::pole, 10.2, 10.2, 2, 3);
  EXPECT_TRUE(scene.view()[BevChannel::pole].empty());
}

TEST(BevPole, OfEachKindFeedsItsChannelAndTheCommonOne) {
  BevScene scene;
  scene.patch(Kind::road, 0, 0, 30, 20, 0.0);
  scene.column(Kind::pole, 5.2, 10.2, 0, 4).column(Kind::sign, 15.2, 10.2, 0, 4);
  scene.column(Kind::light, 25.2, 10.2, 0, 4);
  const BevGrid view = scene.view();
  EXPECT_EQ(view[BevChannel::pole].size(), 1u);
  EXPECT_EQ(view[BevChannel::sign].size(), 1u);
  EXPECT_EQ(view[BevChannel::light].size(), 1u);
  EXPECT_EQ(view[BevChannel::pole_like].size(), 3u);
}

}  // namespace
}  // namespace xview::test
