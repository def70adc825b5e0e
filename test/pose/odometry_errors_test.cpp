// SPDX-License-Identifier: BSD-3-Clause
#include "../../src/pose/odometry_errors.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "base/random.h"

namespace xview::pose {
namespace {

/// A drive along x of 1 m steps that ends at the origin.
struct Drive {
  explicit Drive(int metres) {
    for (int i = metres; i >= 0; --i) {
      ways_m.push_back(i);
      sensors.emplace_back(-i, 0, 0);
    }
  }
  DriftChain chain(const DriftChain::Rates& rates, double reach_m = 40) const {
    return DriftChain(ways_m, sensors, reach_m, rates);
  }
  std::vector<double> ways_m;
  std::vector<Eigen::Vector3d> sensors;
};

Eigen::MatrixXd covarianceOf(const DriftChain& chain) { return chain.information().inverse(); }

TEST(DriftChain, TheLastPoseHasNoError) {
  const Drive drive(40);
  const DriftChain chain = drive.chain({0.02, 1e-3});
  const Eigen::VectorXd errors = Eigen::VectorXd::Ones(chain.size());
  EXPECT_EQ(chain.errorOf(40, errors), Vector6d::Zero());
}

TEST(DriftChain, ErrorsAreLinearBetweenKnots) {
  const Drive drive(40);
  const DriftChain chain = drive.chain({0.02, 1e-3});
  ASSERT_EQ(chain.size(), 6 * 8);
  Eigen::VectorXd errors = Eigen::VectorXd::Zero(chain.size());
  for (Eigen::Index k = 0; k < 8; ++k) errors(6 * k) = 5.0 * static_cast<double>(k + 1);
  for (std::size_t pose = 0; pose <= 40; ++pose)
    EXPECT_NEAR(chain.errorOf(pose, errors)(0), drive.ways_m[pose], 1e-9);
}

TEST(DriftChain, PosesOutOfReachErrLikeTheLastOneInReach) {
  const DriftChain chain = Drive(100).chain({0.02, 1e-3}, 20);
  Eigen::VectorXd errors = Eigen::VectorXd::Zero(chain.size());
  errors.tail<6>().setConstant(3);
  EXPECT_NEAR(chain.errorOf(0, errors)(1), 3, 1e-9);
}

TEST(DriftChain, ErrorsGrowWithTheWayByAboutTheRate) {
  constexpr double kRate = 0.02;
  const Eigen::MatrixXd covariance = covarianceOf(Drive(40).chain({kRate, 1e-9}));
  double before = 0;
  for (Eigen::Index k = 0; k < 8; ++k) {
    const double way_m = 5.0 * static_cast<double>(k + 1);
    const double sigma = std::sqrt(covariance(6 * k, 6 * k));
    EXPECT_GT(sigma, before);
    before = sigma;
    if (way_m < 20) continue;  // the random walk is the larger part of short ways
    EXPECT_GT(sigma, 0.8 * kRate * way_m);
    EXPECT_LT(sigma, 1.2 * kRate * way_m);
  }
}

TEST(DriftChain, ATurnMovesWhatLiesBehindSideways) {
  constexpr double kTurn = 1e-3;
  const Eigen::MatrixXd covariance = covarianceOf(Drive(40).chain({1e-4, kTurn}));
  const Eigen::Index far = 6 * 7;
  // A steady turn by 40 mrad over 40 m bends the way by half of that times the way.
  EXPECT_NEAR(std::sqrt(covariance(far + 1, far + 1)), 0.5 * 40 * 40 * kTurn, 0.3 * 0.8);
  EXPECT_LT(std::sqrt(covariance(far, far)), 0.01) << "but not lengthwise";
}

TEST(DriftChain, InformationIsThatOfAllAxesTogether) {
  const DriftChain chain = Drive(33).chain({0.03, 8e-4});
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(chain.size(), chain.size());
  for (Eigen::Index axis = 0; axis < 6; ++axis) sum += chain.informationOf(axis);
  EXPECT_TRUE(sum.isApprox(chain.information()));
  // What lies along the way says nothing about a turn, nor the other way round.
  Eigen::VectorXd shift = Eigen::VectorXd::Zero(chain.size());
  for (Eigen::Index k = 0; k < shift.size(); k += 6) shift(k) = 0.1;
  EXPECT_GT(shift.dot(chain.informationOf(0) * shift), 0);
  EXPECT_EQ(shift.dot(chain.informationOf(5) * shift), 0);
}

TEST(DriftChain, InformationIsPositiveDefinite) {
  const DriftChain chain = Drive(33).chain({0.03, 8e-4});
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(chain.information());
  EXPECT_GT(axes.eigenvalues()(0), 0);
}

TEST(DriftChain, WhoStandsStillOrIsTrustedDoesNotDrift) {
  EXPECT_EQ(Drive(0).chain({0.02, 1e-3}).size(), 0);
  EXPECT_EQ(Drive(40).chain({0, 1e-3}).size(), 0);
  const DriftChain none = Drive(40).chain({0, 0});
  EXPECT_EQ(none.errorOf(0, Eigen::VectorXd()), Vector6d::Zero());
}

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
}  // namespace xview::pose
