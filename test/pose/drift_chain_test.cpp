// SPDX-License-Identifier: BSD-3-Clause
#include "../../src/pose/drift_chain.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

namespace xview {
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
  EXPECT_EQ(chain.at(chain.placeOf(40), errors), Vector6d::Zero());
}

TEST(DriftChain, ErrorsAreLinearBetweenKnots) {
  const Drive drive(40);
  const DriftChain chain = drive.chain({0.02, 1e-3});
  ASSERT_EQ(chain.knots(), 8u);
  Eigen::VectorXd errors = Eigen::VectorXd::Zero(chain.size());
  for (Eigen::Index k = 0; k < 8; ++k) errors(6 * k) = 5.0 * static_cast<double>(k + 1);
  for (std::size_t pose = 0; pose <= 40; ++pose)
    EXPECT_NEAR(chain.at(chain.placeOf(pose), errors)(0), drive.ways_m[pose], 1e-9);
}

TEST(DriftChain, PosesOutOfReachErrLikeTheLastOneInReach) {
  const DriftChain chain = Drive(100).chain({0.02, 1e-3}, 20);
  Eigen::VectorXd errors = Eigen::VectorXd::Zero(chain.size());
  errors.tail<6>().setConstant(3);
  EXPECT_NEAR(chain.at(chain.placeOf(0), errors)(1), 3, 1e-9);
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
  EXPECT_EQ(Drive(0).chain({0.02, 1e-3}).knots(), 0u);
  EXPECT_EQ(Drive(40).chain({0, 1e-3}).knots(), 0u);
  const DriftChain none = Drive(40).chain({0, 0});
  EXPECT_EQ(none.at(none.placeOf(0), Eigen::VectorXd()), Vector6d::Zero());
}

}  // namespace
}  // namespace xview
