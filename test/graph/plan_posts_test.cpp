// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "plan_scene.h"

namespace xview::test {
namespace {

TEST(PlanPole, IsOnePeakUnderSmearAlongTheRay) {
  PlanScene scene;
  scene.patch(Kind::road, 0, 0, 20, 20, 0.0);
  scene.column(Kind::pole, 10.2, 10.2, 0, 5).column(Kind::pole, 10.3, 10.3, 0, 5);
  for (double d = 0.4; d < 2.0; d += 0.2)
    scene.column(Kind::pole, 10.2 + d, 10.2 + 0.3 * d, 1, 2.5);
  const PlanView view = scene.view();
  for (const Channel channel : {Channel::pole, Channel::pole_like}) {
    ASSERT_EQ(view[channel].size(), 1u) << toString(channel);
    EXPECT_LT(distanceTo(view, channel, 10.25, 10.25), 0.5) << toString(channel);
  }
  EXPECT_TRUE(view[Channel::sign].empty());
}

TEST(PlanPole, AWeakerPeakAMetreAwayIsTheSamePole) {
  PlanScene scene;
  scene.patch(Kind::road, 0, 0, 20, 20, 0.0);
  scene.column(Kind::pole, 10.2, 10.2, 0, 5).column(Kind::pole, 11.2, 10.2, 0, 3);
  const PlanView view = scene.view();
  ASSERT_EQ(view[Channel::pole].size(), 1u);
  EXPECT_LT(distanceTo(view, Channel::pole, 10.2, 10.2), 0.05);
}

TEST(PlanPole, TwoThatStandTwoAndAHalfMetresApartAreTwo) {
  PlanScene scene;
  scene.patch(Kind::road, 0, 0, 20, 20, 0.0);
  scene.column(Kind::pole, 8.2, 10.2, 0, 5).column(Kind::pole, 10.7, 10.2, 0, 5);
  const PlanView view = scene.view();
  ASSERT_EQ(view[Channel::pole].size(), 2u);
  EXPECT_LT(distanceTo(view, Channel::pole, 8.2, 10.2), 0.05);
  EXPECT_LT(distanceTo(view, Channel::pole, 10.7, 10.2), 0.05);
}

TEST(PlanPole, InARowOfBollardsIsOneOfItsOwn) {
  PlanScene scene;
  scene.patch(Kind::sidewalk, 0, 0, 20, 20, 0);
  for (const double x : {6.2, 7.8, 9.4}) scene.column(Kind::pole, x, 10.2, 0, 1);
  scene.column(Kind::pole, 7.8, 10.2, 0, 1);  // one was seen better
  const PlanView view = scene.view();
  ASSERT_EQ(view[Channel::pole].size(), 3u);
  for (const double x : {6.2, 7.8, 9.4}) EXPECT_LT(distanceTo(view, Channel::pole, x, 10.2), 0.05);
}

TEST(PlanPole, IsNotThereTwiceBecauseOfItsLamp) {
  PlanScene scene;
  scene.patch(Kind::sidewalk, 0, 0, 20, 20, 0);
  scene.column(Kind::pole, 10.2, 10.2, 0, 6).column(Kind::pole, 10.2, 10.2, 0, 6);
  for (int i = 0; i < 3; ++i) scene.column(Kind::pole, 11.8, 10.2, 5, 6);
  EXPECT_EQ(scene.view()[Channel::pole].size(), 1u);
}

TEST(PlanPole, IsNotBelievedFromFarAway) {
  PlanScene scene;
  scene.patch(Kind::road, 0, 0, 20, 20, 0.0);
  for (double z = 0.1; z < 5; z += 0.2) scene.point(Kind::sign, 10.2, 10.2, z, 1, false);
  const PlanView view = scene.view();
  EXPECT_TRUE(view[Channel::sign].empty());
  EXPECT_TRUE(view[Channel::pole_like].empty());
  EXPECT_FALSE(view[Channel::obstacle_low].empty());
}

TEST(PlanPole, InsideAHouseIsAWrongLabel) {
  PlanScene scene;
  scene.patch(Kind::road, 0, 0, 20, 8, 0.0).wall(Kind::building, 0, 10.2, 20, 10.2, 0, 9);
  scene.column(Kind::pole, 10.2, 10.2, 2, 3);
  EXPECT_TRUE(scene.view()[Channel::pole].empty());
}

TEST(PlanPole, BeforeAWallIsSeenByThePlacesThatItOutvotes) {
  PlanScene scene;
  scene.patch(Kind::road, 0, 0, 20, 8, 0.0);
  for (int i = 0; i < 4; ++i) scene.wall(Kind::building, 0, 10.35, 20, 10.35, 0, 9);
  scene.column(Kind::pole, 10.2, 10.1, 0.3, 1.2).column(Kind::pole, 10.2, 10.1, 0.3, 1.2);
  const PlanView view = scene.view();
  ASSERT_EQ(view[Channel::pole].size(), 1u);
  EXPECT_LT((inFrame(view, view[Channel::pole][0]) - Eigen::Vector2d(10.2, 10.1)).norm(), 0.1);
}

TEST(PlanPole, OfEachKindFeedsItsChannelAndTheCommonOne) {
  PlanScene scene;
  scene.patch(Kind::road, 0, 0, 30, 20, 0.0);
  scene.column(Kind::pole, 5.2, 10.2, 0, 4).column(Kind::sign, 15.2, 10.2, 0, 4);
  scene.column(Kind::light, 25.2, 10.2, 0, 4);
  const PlanView view = scene.view();
  EXPECT_EQ(view[Channel::pole].size(), 1u);
  EXPECT_EQ(view[Channel::sign].size(), 1u);
  EXPECT_EQ(view[Channel::light].size(), 1u);
  EXPECT_EQ(view[Channel::pole_like].size(), 3u);
}

/// A thin thing whose labels a network cannot agree on: half vegetation, half building.
void addConfusedPost(PlanScene& scene, double x, double y, double top) {
  for (int i = 0; i < 12; ++i) {
    scene.column(i % 2 ? Kind::vegetation : Kind::building, x + 0.01 * i, y, 0.3, top);
  }
}

TEST(PlanColumn, APostOfConfusedLabelsIsPoleLike) {
  PlanScene scene;
  scene.patch(Kind::road, 0, 0, 20, 20, 0);
  addConfusedPost(scene, 10.2, 10.2, 4);
  const PlanView view = scene.view();
  EXPECT_TRUE(view[Channel::pole].empty()) << "no label says so";
  ASSERT_EQ(view[Channel::pole_like].size(), 1u);
  EXPECT_LT(distanceTo(view, Channel::pole_like, 10.255, 10.2), 0.05);
}

TEST(PlanColumn, LabelsThatAgreeAreBelieved) {
  PlanScene scene;
  scene.patch(Kind::road, 0, 0, 20, 20, 0);
  for (int i = 0; i < 12; ++i)
    scene.column(i % 2 ? Kind::trunk : Kind::vegetation, 10.2 + 0.01 * i, 10.2, 0.3, 4);
  EXPECT_TRUE(scene.view()[Channel::pole_like].empty()) << "trunk and vegetation: a tree";
}

TEST(PlanColumn, MustStandAlone) {
  PlanScene scene;
  scene.patch(Kind::road, 0, 0, 20, 20, 0);
  addConfusedPost(scene, 10.2, 10.2, 4);
  addConfusedPost(scene, 11.2, 10.2, 4);
  EXPECT_TRUE(scene.view()[Channel::pole_like].empty());
}

TEST(PlanColumn, MustBeTaller) {
  PlanScene scene;
  scene.patch(Kind::road, 0, 0, 20, 20, 0);
  addConfusedPost(scene, 10.2, 10.2, 1.9);
  EXPECT_TRUE(scene.view()[Channel::pole_like].empty());
}

TEST(PlanColumn, WiderThanAPoleIsABush) {
  PlanScene scene;
  scene.patch(Kind::road, 0, 0, 20, 20, 0);
  for (const double dx : {-.45, 0., .45}) {
    for (const double dy : {-.45, 0., .45}) addConfusedPost(scene, 10.2 + dx, 10.2 + dy, 4);
  }
  EXPECT_TRUE(scene.view()[Channel::pole_like].empty());
}

TEST(PlanColumn, ThatIsAPoleAlreadyIsNoSecondOne) {
  PlanScene scene;
  scene.patch(Kind::road, 0, 0, 20, 20, 0);
  addConfusedPost(scene, 10.2, 10.2, 4);
  for (int i = 0; i < 6; ++i) scene.column(Kind::pole, 10.2, 10.2, 0.3, 4);
  EXPECT_EQ(scene.view()[Channel::pole_like].size(), 1u);
}

/// A person who is called a pole by half of the labels.
void addPerson(PlanScene& scene, double x, double y, double top) {
  for (int i = 0; i < 12; ++i)
    scene.column(i % 2 ? Kind::pole : Kind::vegetation, x + 0.01 * i, y, 0.3, top);
}

TEST(PlanPole, OfAPersonsHeightBesideHigherThingsIsNone) {
  PlanScene scene;
  scene.patch(Kind::road, 0, 0, 20, 20, 0);
  addPerson(scene, 10.2, 10.2, 1.8);
  scene.wall(Kind::building, 5, 13, 15, 13, 0, 6);
  const PlanView view = scene.view();
  EXPECT_TRUE(view[Channel::pole].empty());
  EXPECT_TRUE(view[Channel::pole_like].empty());
}

TEST(PlanPole, ThatMayHaveBeenCutOffByTheFieldOfViewIsKept) {
  PlanScene scene;
  scene.patch(Kind::road, 0, 0, 20, 20, 0);
  addPerson(scene, 10.2, 10.2, 1.8);
  EXPECT_EQ(scene.view()[Channel::pole].size(), 1u) << "nothing higher was seen beside it";
}

TEST(PlanPole, ThatIsLowButClearlyLabelledIsABollard) {
  PlanScene scene;
  scene.patch(Kind::road, 0, 0, 20, 20, 0);
  for (int i = 0; i < 12; ++i) scene.column(Kind::pole, 10.2, 10.2, 0.3, 1.2);
  scene.wall(Kind::building, 5, 13, 15, 13, 0, 6);
  EXPECT_EQ(scene.view()[Channel::pole].size(), 1u);
}

TEST(PlanPole, OfFewVotesIsBelievedUnlessOthersHaveMoreInItsPlace) {
  const auto polesBeside = [](int bush_votes, double bush_x) {
    PlanScene scene;
    scene.patch(Kind::road, 0, 0, 20, 20, 0);
    for (const double z : {1., 1.5, 2.}) scene.point(Kind::pole, 10.15, 10.2, z);
    for (int i = 0; i < bush_votes; ++i) scene.point(Kind::vegetation, bush_x, 10.2, 1);
    return scene.view()[Channel::pole].size();
  };
  EXPECT_EQ(polesBeside(0, 10.15), 1u);
  EXPECT_EQ(polesBeside(2, 10.15), 1u);
  EXPECT_EQ(polesBeside(8, 10.15), 0u);
  EXPECT_EQ(polesBeside(8, 10.45), 1u) << "behind it";
}

TEST(PlanPole, OfManyVotesIsBelievedBesideABush) {
  PlanScene scene;
  scene.patch(Kind::road, 0, 0, 20, 20, 0).column(Kind::pole, 10.2, 10.2, 0.3, 3);
  for (int i = 0; i < 30; ++i) scene.point(Kind::vegetation, 10.4, 10.4, 1);
  EXPECT_EQ(scene.view()[Channel::pole].size(), 1u);
}

TEST(PlanSign, OnAPostThatIsSeldomCalledOneIsNone) {
  PlanScene scene;
  scene.patch(Kind::road, 0, 0, 20, 20, 0);
  for (int i = 0; i < 4; ++i) scene.column(Kind::pole, 10.2, 10.2, 0, 5);
  scene.column(Kind::sign, 10.2, 10.2, 1, 4);
  const PlanView view = scene.view();
  EXPECT_EQ(view[Channel::pole].size(), 1u);
  EXPECT_TRUE(view[Channel::sign].empty());
}

TEST(PlanSign, ThatHidesAPartOfItsPostIsOne) {
  PlanScene scene;
  scene.patch(Kind::road, 0, 0, 20, 20, 0);
  for (int i = 0; i < 4; ++i) scene.column(Kind::pole, 10.2, 10.2, 0, 3);
  for (int i = 0; i < 4; ++i) scene.column(Kind::sign, 10.2, 10.2, 2.2, 2.9);
  const PlanView view = scene.view();
  EXPECT_EQ(view[Channel::pole].size(), 1u);
  EXPECT_EQ(view[Channel::sign].size(), 1u);
}

/// A street lamp as it looks from above: an arm of 1.5 m with the lamp, and a few places of its
/// post.
void addLampFromAbove(PlanScene& scene, double x, double y, Kind seen_through_post) {
  for (double d = 0; d < 1.5; d += 0.1) scene.column(Kind::pole, x + d, y, 7, 7.4);
  for (int i = 0; i < 20; ++i) scene.point(Kind::pole, x + 1.5, y, 7.5);
  for (double z = 0.6; z < 7; z += 0.5) scene.point(seen_through_post, x, y, z, 0.3f);
}

TEST(PlanFoot, OfALampOnAnArmIsWhereItsPostStands) {
  for (const Kind label : {Kind::pole, Kind::sidewalk}) {
    SCOPED_TRACE(toString(label));
    PlanScene scene;
    scene.patch(Kind::road, 0, 0, 20, 20, 0);
    addLampFromAbove(scene, 10.2, 10.2, label);
    const PlanView view = scene.view();
    for (const Channel channel : {Channel::pole, Channel::pole_like}) {
      ASSERT_EQ(view[channel].size(), 1u) << toString(channel);
      EXPECT_LT(distanceTo(view, channel, 10.2, 10.2), 0.25) << toString(channel);
    }
  }
}

TEST(PlanFoot, OfALampWhoseArmIsLongIsNoSecondPole) {
  PlanScene scene;
  scene.patch(Kind::road, 0, 0, 20, 20, 0);
  scene.column(Kind::pole, 10.2, 10.2, 0, 7);
  for (int i = 0; i < 20; ++i) scene.point(Kind::pole, 12.2, 10.2, 7);
  const PlanView view = scene.view();
  ASSERT_EQ(view[Channel::pole].size(), 1u);
  EXPECT_LT(distanceTo(view, Channel::pole, 10.2, 10.2), 0.05);
}

TEST(PlanFoot, OfALampOnAShortArmIsNotBetweenPostAndLamp) {
  for (const double arm : {0.6, 0.8, 1.0}) {
    SCOPED_TRACE(arm);
    PlanScene scene;
    scene.patch(Kind::road, 0, 0, 20, 20, 0);
    for (double z = 0.6; z < 7; z += 0.5) scene.point(Kind::pole, 10.2, 10.2, z);
    for (int i = 0; i < 10; ++i) scene.point(Kind::pole, 10.2 + arm, 10.2, 7);
    const PlanView view = scene.view();
    ASSERT_EQ(view[Channel::pole].size(), 1u);
    EXPECT_LT(distanceTo(view, Channel::pole, 10.2, 10.2), 0.05);
  }
}

TEST(PlanFoot, OfALampAloneIsBelowIt) {
  PlanScene scene;
  scene.patch(Kind::road, 0, 0, 20, 20, 0);
  for (int i = 0; i < 20; ++i) scene.point(Kind::pole, 12.2, 10.2, 7);
  EXPECT_LT(distanceTo(scene.view(), Channel::pole, 12.2, 10.2), 0.05);
}

TEST(PlanFoot, IsNotInAWallOfWrongLabels) {
  PlanScene scene;
  scene.patch(Kind::road, 0, 0, 20, 9, 0).wall(Kind::building, 0, 11.2, 20, 11.2, 0, 9);
  for (int i = 0; i < 20; ++i) scene.point(Kind::pole, 10.2, 10.2, 7);
  scene.column(Kind::terrain, 10.2, 11.2, 1, 6);
  EXPECT_LT(distanceTo(scene.view(), Channel::pole, 10.2, 10.2), 0.05);
}

TEST(PlanFoot, OfASignIsItsOwnNotThatOfTheLampBesideIt) {
  PlanScene scene;
  scene.patch(Kind::road, 0, 0, 20, 20, 0);
  scene.column(Kind::pole, 10.2, 10.2, 0, 7);
  for (int i = 0; i < 20; ++i) scene.point(Kind::sign, 11.7, 10.2, 2.5);
  const PlanView view = scene.view();
  EXPECT_LT(distanceTo(view, Channel::sign, 11.7, 10.2), 0.05);
}

TEST(PlanFoot, OfABollardIsItsOwnNotThatOfTheLampBesideIt) {
  PlanScene scene;
  scene.patch(Kind::road, 0, 0, 20, 20, 0);
  scene.column(Kind::pole, 10.2, 10.2, 0, 7).column(Kind::pole, 12.2, 10.2, 0, 1);
  const PlanView view = scene.view();
  ASSERT_EQ(view[Channel::pole].size(), 2u);
  EXPECT_LT(distanceTo(view, Channel::pole, 12.2, 10.2), 0.05);
}

}  // namespace
}  // namespace xview::test
