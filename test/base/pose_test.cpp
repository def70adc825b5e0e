// SPDX-License-Identifier: BSD-3-Clause
#include "base/pose.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/random.h"
#include "xview/base/localization.h"

namespace xview {
namespace {

Eigen::Matrix3d randomRotation(Random& random) {
  Eigen::Quaterniond q(random.normal(), random.normal(), random.normal(), random.normal());
  return q.normalized().toRotationMatrix();
}

TEST(YawOf, IsTheInverseOfPoseFromYaw) {
  for (double yaw = -3.1; yaw < 3.14; yaw += 0.1) {
    const Eigen::Isometry3d T = poseFromYaw({1, 2, 3}, yaw);
    EXPECT_NEAR(yawOf(T.linear()), yaw, 1e-12);
    EXPECT_EQ(T.translation(), Eigen::Vector3d(1, 2, 3));
    EXPECT_EQ(T * Eigen::Vector3d::UnitZ() - T.translation(), Eigen::Vector3d::UnitZ());
  }
}

TEST(RotationBetween, IsTheAngleWhateverTheAxisAndTheTranslation) {
  Random random(1);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d axis = randomRotation(random).col(0);
    const double angle = random.uniform(0, M_PI);
    Eigen::Isometry3d a = Eigen::Isometry3d::Identity(), b = a;
    a.linear() = randomRotation(random);
    b.linear() = a.linear() * Eigen::AngleAxisd(angle, axis).toRotationMatrix();
    b.translation() << 5, 6, 7;
    EXPECT_NEAR(rotationBetween(a, b), angle, 1e-7);
    EXPECT_NEAR(rotationBetween(b, a), angle, 1e-7);
  }
}

TEST(AngleDifference, WrapsToHalfATurn) {
  EXPECT_NEAR(angleDifference(3, -3), 6 - 2 * M_PI, 1e-12);
  EXPECT_NEAR(angleDifference(0.1, 0.3), -0.2, 1e-12);
  EXPECT_NEAR(angleDifference(100 * M_PI + 0.5, 0), 0.5, 1e-9);
  EXPECT_NEAR(std::abs(angleDifference(M_PI, 0)), M_PI, 1e-12);
}

TEST(Orthonormalized, IsAProperRotationNearTheInput) {
  Random random(2);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Matrix3d R = randomRotation(random);
    Eigen::Matrix3d noisy = R;
    for (int k = 0; k < 9; ++k) noisy(k) += 1e-3 * random.normal();
    const Eigen::Matrix3d fixed = orthonormalized(noisy);
    EXPECT_LT((fixed * fixed.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
    EXPECT_GT(fixed.determinant(), 0);
    EXPECT_LT((fixed - R).norm(), 0.01);
  }
}

TEST(Orthonormalized, NeverGivesAMirror) {
  Eigen::Matrix3d mirror = Eigen::Matrix3d::Identity();
  mirror(2, 2) = -1;
  EXPECT_NEAR(orthonormalized(mirror).determinant(), 1, 1e-12);
}

TEST(IsRigid, RefusesScaleMirrorShearNanAndABadLastRow) {
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
  EXPECT_TRUE(isRigid(T));
  T(0, 3) = 1e6;
  EXPECT_TRUE(isRigid(T));
  T.topLeftCorner<3, 3>() *= 1.01;
  EXPECT_FALSE(isRigid(T));
  T.setIdentity();
  T(2, 2) = -1;
  EXPECT_FALSE(isRigid(T));
  T.setIdentity();
  T(0, 1) = 0.01;
  EXPECT_FALSE(isRigid(T));
  T.setIdentity();
  T(1, 3) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(isRigid(T));
  T.setIdentity();
  T(3, 0) = 0.1;
  EXPECT_FALSE(isRigid(T));
}

TEST(SamePlace, LooksAtDistanceAndTurn) {
  PlacePose a, b;
  b.x = 5;
  b.y = 5;
  EXPECT_TRUE(samePlace(a, b));
  b.y = 7;
  EXPECT_FALSE(samePlace(a, b));
  b = a;
  a.yaw = 3.1;
  b.yaw = -3.1;
  EXPECT_TRUE(samePlace(a, b));
  b.yaw = 0;
  EXPECT_FALSE(samePlace(a, b));
}

}  // namespace
}  // namespace xview
