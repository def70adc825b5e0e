// SPDX-License-Identifier: BSD-3-Clause
#include "../../src/pose/residuals.h"

#include <ceres/autodiff_cost_function.h>
#include <ceres/numeric_diff_cost_function.h>
#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "base/pose.h"
#include "base/random.h"

namespace xview::pose {
namespace {

using Pose = std::array<double, 7>;

Pose asArray(const Eigen::Isometry3d& T) {
  const Eigen::Quaterniond q(T.linear());
  return {
      T.translation().x(), T.translation().y(), T.translation().z(), q.x(), q.y(), q.z(), q.w()};
}

Eigen::Isometry3d randomPose(Random& random) {
  Eigen::Isometry3d T = poseFromYaw(
      {random.uniform(-9, 9), random.uniform(-9, 9), random.uniform(-9, 9)}, random.uniform(-3, 3));
  T.rotate(Eigen::AngleAxisd(random.uniform(-1, 1), Eigen::Vector3d(1, -2, 0.5).normalized()));
  return T;
}

/// Largest difference between the automatic and the numeric derivative, relative to the larger
/// ones.
template <class Functor, int kResiduals, int... kSizes>
double jacobianError(const Functor& functor, const std::vector<const double*>& parameters) {
  const ceres::AutoDiffCostFunction<Functor, kResiduals, kSizes...> automatic(new Functor(functor));
  const ceres::NumericDiffCostFunction<Functor, ceres::RIDDERS, kResiduals, kSizes...> numeric(
      new Functor(functor));
  const std::vector<int> sizes{kSizes...};
  std::vector<std::vector<double>> a, n;
  std::vector<double*> a_rows, n_rows;
  for (const int size : sizes) {
    a.emplace_back(static_cast<std::size_t>(kResiduals * size));
    n.emplace_back(static_cast<std::size_t>(kResiduals * size));
  }
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    a_rows.push_back(a[i].data());
    n_rows.push_back(n[i].data());
  }
  std::array<double, kResiduals> residuals;
  EXPECT_TRUE(automatic.Evaluate(parameters.data(), residuals.data(), a_rows.data()));
  EXPECT_TRUE(numeric.Evaluate(parameters.data(), residuals.data(), n_rows.data()));
  double error = 0, scale = 1;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t k = 0; k < a[i].size(); ++k) {
      error = std::max(error, std::abs(a[i][k] - n[i][k]));
      scale = std::max(scale, std::abs(n[i][k]));
    }
  }
  return error / scale;
}

TEST(OdometryResidual, IsZeroExactlyForTheMeasuredMotion) {
  Random random(1);
  const Eigen::Isometry3d A = randomPose(random), B = randomPose(random);
  const OdometryResidual residual{A.inverse() * B, 0.1, 0.01};
  std::array<double, 6> r;
  const Pose a = asArray(A), b = asArray(B);
  residual(a.data(), b.data(), r.data());
  for (const double x : r) EXPECT_NEAR(x, 0, 1e-10);
  const Pose beyond = asArray(B * Eigen::Translation3d(0.3, 0, 0));
  residual(a.data(), beyond.data(), r.data());
  EXPECT_NEAR(std::hypot(std::hypot(r[0], r[1]), r[2]), 3, 1e-9);
}

TEST(OdometryResidual, MeasuresTheAngleInRadiansForEitherSignOfTheQuaternion) {
  const Pose a = asArray(Eigen::Isometry3d::Identity());
  Pose b = asArray(poseFromYaw(Eigen::Vector3d::Zero(), 0.02));
  std::array<double, 6> r;
  for (int sign = 0; sign < 2; ++sign) {
    OdometryResidual{Eigen::Isometry3d::Identity(), 1, 0.01}(a.data(), b.data(), r.data());
    EXPECT_NEAR(r[5], 2, 1e-3);
    for (int i = 3; i < 7; ++i) b[static_cast<std::size_t>(i)] *= -1;
  }
}

TEST(ObservationResidual, IsZeroWhereTheVertexWasSeen) {
  Random random(2);
  const Eigen::Isometry3d T = randomPose(random);
  const Eigen::Vector3d seen(4, -1, 2), vertex = T * seen;
  std::array<double, 3> r;
  const Pose pose = asArray(T);
  ObservationResidual{seen, 0.2}(pose.data(), vertex.data(), r.data());
  for (const double x : r) EXPECT_NEAR(x, 0, 1e-10);
}

TEST(MatchResidual, IsTheMahalanobisDistance) {
  Eigen::Matrix3d covariance;
  covariance << 4, 1, 0, 1, 2, 0.5, 0, 0.5, 1;
  const Eigen::Matrix3d L = covariance.llt().matrixL();
  const Eigen::Vector3d p_map(1, 2, 3), vertex(3, 1, 2);
  std::array<double, 3> r;
  MatchResidual{p_map, L.inverse()}(vertex.data(), r.data());
  const Eigen::Vector3d e = vertex - p_map;
  EXPECT_NEAR(r[0] * r[0] + r[1] * r[1] + r[2] * r[2], e.dot(covariance.inverse() * e), 1e-10);
}

TEST(GravityResidual, IsTheTilt) {
  Eigen::Isometry3d T = poseFromYaw({5, 5, 5}, 1);
  T.rotate(Eigen::AngleAxisd(0.03, Eigen::Vector3d::UnitX()));
  std::array<double, 2> r;
  const Pose pose = asArray(T);
  GravityResidual{Eigen::Vector3d::UnitZ(), 0.01}(pose.data(), r.data());
  EXPECT_NEAR(std::hypot(r[0], r[1]), 3, 1e-3);
}

TEST(Residuals, HaveTheJacobiansOfNumericDifferences) {
  Random random(3);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Isometry3d A = randomPose(random), B = randomPose(random);
    const Pose a = asArray(A), b = asArray(B);
    Eigen::Isometry3d near = A.inverse() * B;
    near.rotate(Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitY()));
    const Eigen::Vector3d p(random.uniform(-5, 5), random.uniform(-5, 5), 1), seen(1, 2, 3);
    Eigen::Matrix3d inverse_L;
    inverse_L << 2, 0, 0, -1, 3, 0, 0.5, 0.2, 1;
    EXPECT_LT((jacobianError<OdometryResidual, 6, 7, 7>({near, 0.1, 0.01}, {a.data(), b.data()})),
              1e-7);
    EXPECT_LT((jacobianError<ObservationResidual, 3, 7, 3>({seen, 0.2}, {a.data(), p.data()})),
              1e-7);
    EXPECT_LT((jacobianError<MatchResidual, 3, 3>({seen, inverse_L}, {p.data()})), 1e-7);
    EXPECT_LT((jacobianError<GravityResidual, 2, 7>({seen.normalized(), 0.01}, {a.data()})), 1e-7);
  }
}

}  // namespace
}  // namespace xview::pose
