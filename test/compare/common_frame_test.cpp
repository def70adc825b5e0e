// SPDX-License-Identifier: BSD-3-Clause
#include "xview/mapper.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/pose.h"
#include "compare/self_similarity.h"
#include "localizer/simulated_drive.h"

namespace xview::test {
namespace {

/// The map of a session whose frame lies at a pose in that of the town.
map::SemanticMap mapMovedBy(const std::string& session, const Eigen::Isometry3d& T_moved_town) {
  const SimulatedRecording& recording = *simulatedDrive().sessions.at(session);
  std::vector<Eigen::Isometry3d> truth;
  const std::size_t frames = std::min<std::size_t>(30, recording.size());
  for (std::size_t i = 0; i < frames; ++i) truth.push_back(recording.truth(i));
  const PosedRecording in_town(recording, 0, truth);
  const PosedRecording moved(in_town, T_moved_town);
  return buildMap({&moved}, {});
}

Eigen::Isometry3d shift(double x, double y, double yaw = 0) { return poseFromYaw({x, y, 0}, yaw); }

TEST(CommonFrame, TwoVisitsInOneFrameAgree) {
  const auto evidence =
      evidenceOfOneFrame(simulatedDrive().map, mapMovedBy("rear", shift(0, 0)), {});
  ASSERT_TRUE(evidence);
  EXPECT_FALSE(evidence->contradicts());
  EXPECT_GT(evidence->agreement(), 0.5);
  EXPECT_GT(evidence->area_m2, 500);
}

/// Along a street much fits some metres on as well; to its side it does not.
TEST(CommonFrame, AFrameBesideTheOtherContradicts) {
  const SimulatedRecording& rear = *simulatedDrive().sessions.at("rear");
  const Eigen::Vector3d way = rear.truth(10).translation() - rear.truth(0).translation();
  const Eigen::Vector2d left = Eigen::Vector2d(-way.y(), way.x()).normalized();
  for (const double metres : {-6., -3., 3., 6.}) {
    const Eigen::Vector2d by = metres * left;
    const auto evidence =
        evidenceOfOneFrame(simulatedDrive().map, mapMovedBy("rear", shift(by.x(), by.y())), {});
    ASSERT_TRUE(evidence);
    EXPECT_TRUE(evidence->contradicts())
        << metres << " m: " << evidence->score << " of " << evidence->expected;
  }
}

TEST(CommonFrame, ASmallShiftIsFound) {
  const auto evidence =
      evidenceOfOneFrame(simulatedDrive().map, mapMovedBy("rear", shift(2, 2)), {});
  ASSERT_TRUE(evidence);
  EXPECT_GT(evidence->nearby, 0.5 * evidence->expected);
  EXPECT_NEAR(evidence->shift_m, std::hypot(2, 2), 1);
}

TEST(CommonFrame, PlacesThatShareNothingTellNothing) {
  const auto far = mapMovedBy("rear", shift(2000, 0));
  EXPECT_FALSE(evidenceOfOneFrame(simulatedDrive().map, far, {}));
}

/// A map that does not know its null is asked as a whole.
TEST(CommonFrame, ThePartOfAMapWhereTheOtherLiesTellsAsMuchAsAllOfIt) {
  map::SemanticMap map = simulatedDrive().map;
  measureNullHypothesis(map, {});  // of the view as it is rounded
  map::SemanticMap whole = map;
  whole.null = {};
  for (const double beside_m : {0., 3.}) {
    const map::SemanticMap rear = mapMovedBy("rear", shift(beside_m, 0));
    const auto of_part = evidenceOfOneFrame(map, rear, {}),
               of_all = evidenceOfOneFrame(whole, rear, {});
    ASSERT_TRUE(of_part && of_all);
    EXPECT_EQ(of_part->score, of_all->score);
    EXPECT_EQ(of_part->nearby, of_all->nearby);
    EXPECT_EQ(of_part->area_m2, of_all->area_m2);
  }
}

TEST(CommonFrame, AnotherMethodAndAPriorChangeNothing) {
  const map::SemanticMap rear = mapMovedBy("rear", shift(0, 0));
  Options options;
  const auto plain = evidenceOfOneFrame(simulatedDrive().map, rear, options);
  options.method = "walks";
  options.prior.near = "900,900,5";
  EXPECT_EQ(evidenceOfOneFrame(simulatedDrive().map, rear, options)->score, plain->score);
}

TEST(CommonFrame, ADriveIsKnownAgainWhereverItWasPut) {
  EXPECT_TRUE(holdsSameDrive(simulatedDrive().map, mapMovedBy("forward", shift(40, -3, 1))));
  EXPECT_FALSE(holdsSameDrive(simulatedDrive().map, mapMovedBy("rear", shift(0, 0))));
  EXPECT_FALSE(holdsSameDrive(map::SemanticMap(), simulatedDrive().map));
}

}  // namespace
}  // namespace xview::test
