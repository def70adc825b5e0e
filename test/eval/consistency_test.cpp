// SPDX-License-Identifier: BSD-3-Clause
#include "xview/eval/consistency.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

namespace xview {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;

/// Small against a radian, correlated, and with axes of different length.
Matrix6d someCovariance() {
  Vector6d sigma;
  sigma << 0.3, 0.1, 0.05, 0.002, 0.004, 0.01;
  Matrix6d correlation = Matrix6d::Identity();
  correlation(0, 5) = correlation(5, 0) = 0.8;
  correlation(1, 2) = correlation(2, 1) = -0.5;
  return sigma.asDiagonal() * correlation * sigma.asDiagonal();
}

Eigen::Isometry3d somePose() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = Eigen::Vector3d(40, -30, 2);
  T.linear() =
      Eigen::AngleAxisd(2.5, Eigen::Vector3d(0.1, -0.2, 1).normalized()).toRotationMatrix();
  return T;
}

Eigen::Isometry3d moved(Eigen::Isometry3d T, const Vector6d& left_increment) {
  const Eigen::Vector3d turn = left_increment.tail<3>();
  T.translation() += left_increment.head<3>();
  if (turn.norm() > 0) T.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * T.linear();
  return T;
}

std::vector<double> sampled(const Matrix6d& drawn_from, const Matrix6d& claimed) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const Matrix6d L = drawn_from.llt().matrixL();
  std::vector<double> values;
  for (int i = 0; i < 20000; ++i) {
    const Vector6d unit = Vector6d::NullaryExpr([&](Eigen::Index) { return normal(random); });
    values.push_back(normalisedErrorSquared(claimed, moved(somePose(), L * unit), somePose()));
  }
  return values;
}

TEST(NormalisedErrorSquared, OfSamplesFromTheCovarianceIsChiSquareOfSix) {
  const Consistency c = consistencyOf(sampled(someCovariance(), someCovariance()));
  EXPECT_EQ(c.answers, 20000u);
  EXPECT_NEAR(c.mean, 1, 0.02);
  EXPECT_NEAR(c.median, 0.891, 0.02);
  EXPECT_NEAR(c.within_3_sigma, 0.9973, 0.0015);
}

TEST(NormalisedErrorSquared, OfACovarianceTwiceTooWideIsHalf) {
  EXPECT_NEAR(consistencyOf(sampled(someCovariance(), 2 * someCovariance())).mean, 0.5, 0.01);
}

TEST(NormalisedErrorSquared, CountsEachAxisInItsOwnSigma) {
  Vector6d sigma;
  sigma << 1, 2, 3, 0.01, 0.02, 0.03;
  const Matrix6d covariance = sigma.cwiseAbs2().asDiagonal();
  for (int axis = 0; axis < 6; ++axis) {
    const Vector6d step = 2 * sigma(axis) * Vector6d::Unit(axis);
    EXPECT_NEAR(normalisedErrorSquared(covariance, moved(somePose(), step), somePose()), 4, 1e-6)
        << axis;
  }
}

TEST(NormalisedErrorSquared, IsZeroAtTheTruth) {
  EXPECT_NEAR(normalisedErrorSquared(someCovariance(), somePose(), somePose()), 0, 1e-9);
}

TEST(NormalisedErrorSquared, WithoutACovarianceIsInfinite) {
  EXPECT_TRUE(std::isinf(normalisedErrorSquared(Matrix6d::Zero(), somePose(), somePose())));
  EXPECT_TRUE(std::isinf(normalisedErrorSquared(-someCovariance(), somePose(), somePose())));
}

TEST(Consistency, CountsTheLimitOfThreeSigmaItself) {
  const Consistency c = consistencyOf({kThreeSigmaOfSix, 2 * kThreeSigmaOfSix, 6, 0});
  EXPECT_DOUBLE_EQ(c.within_3_sigma, 0.75);
  EXPECT_DOUBLE_EQ(c.mean, (3 * kThreeSigmaOfSix + 6) / 24);
}

TEST(Consistency, OfNoAnswerIsUnknown) {
  const Consistency c = consistencyOf({});
  EXPECT_EQ(c.answers, 0u);
  EXPECT_TRUE(std::isnan(c.mean) && std::isnan(c.median) && std::isnan(c.within_3_sigma));
}

}  // namespace
}  // namespace xview
