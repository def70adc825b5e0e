// SPDX-License-Identifier: BSD-3-Clause
#include "../../src/pose/pose_jitter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "xview/types/random.h"

namespace xview {
namespace {

constexpr double kGround = 2.25;  ///< ground moves a pose by that much less than it is off

/// Poses over level ground and between fronts, of `blocks` blocks each; every point errs on its own
/// and every pose by a roll of this spread.
std::vector<PosePull> poses(int count, int blocks, double roll_rad) {
  Random random(11);
  std::vector<PosePull> all;
  for (int i = 0; i < count; ++i) {
    PosePull pose;
    const double roll = roll_rad * random.normal();
    for (int b = 0; b < blocks; ++b) {
      constexpr double kInformation = 4e4, kNoise_m = 0.002;
      const Eigen::Vector3d p(random.uniform(-10, 10), random.uniform(-10, 10), -1.5);
      const Eigen::Vector3d n = b % 2 == 0   ? Eigen::Vector3d::UnitZ()
                                : b % 4 == 1 ? Eigen::Vector3d::UnitX()
                                             : Eigen::Vector3d::UnitY();
      Vector6d j;
      j << n, p.cross(n);
      const Vector6d pull = kInformation * j * (roll * j(3) + kNoise_m * random.normal());
      pose.information += kInformation * j * j.transpose();
      pose.pull += pull;
      pose.of_blocks += pull * pull.transpose();
      ++pose.blocks;
    }
    all.push_back(pose);
  }
  return all;
}

double degrees(double variance) { return std::sqrt(variance) * 180 / M_PI; }

TEST(PoseJitter, FindsTheSpreadOfTheTilt) {
  constexpr double kRoll = 0.004;
  const Vector6d jitter = poseJitter(poses(60, 40, kRoll));
  EXPECT_EQ(jitter(3), jitter(4)) << "roll and pitch are one tilt";
  // Only one of both axes rolls.
  EXPECT_NEAR(degrees(jitter(3)), kGround * degrees(kRoll * kRoll / 2),
              0.25 * degrees(kRoll * kRoll));
}

TEST(PoseJitter, IsNoneWhereBlocksErrEachOnItsOwn) {
  const Vector6d jitter = poseJitter(poses(60, 40, 0));
  EXPECT_LT(degrees(jitter(3)), 0.02);
  EXPECT_LT(std::sqrt(jitter(2)), 0.001);
}

TEST(PoseJitter, GrowsWithTheJitter) {
  double before = 0;
  for (const double roll : {0.001, 0.002, 0.004}) {
    const double found = poseJitter(poses(60, 40, roll))(3);
    EXPECT_GT(found, before);
    before = found;
  }
}

TEST(PoseJitter, PosesThatSeeLittleDoNotCount) {
  EXPECT_EQ(poseJitter({}), Vector6d::Zero());
  EXPECT_EQ(poseJitter(poses(60, 5, 0.01)), Vector6d::Zero());
  EXPECT_EQ(poseJitter(std::vector<PosePull>(10)), Vector6d::Zero());
}

}  // namespace
}  // namespace xview
