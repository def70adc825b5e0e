// SPDX-License-Identifier: BSD-3-Clause
#include "pose/posterior.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/pose.h"
#include "base/random.h"

namespace xview::pose {
namespace {

/// A drive of 60 m past landmarks, and what a robot with known errors makes of it.
struct Drive {
  std::vector<Eigen::Isometry3d> T_map_sensor;  // truth
  std::vector<Eigen::Isometry3d> T_odom_sensor;
  std::vector<MatchedVertex> vertices;
  Eigen::Isometry3d T_map_query = Eigen::Isometry3d::Identity();  // true for the first pose
};

struct DriveNoise {
  double odometry_m = 0, odometry_rad = 0, vertex_m = 0, match_m = 0;
};

Eigen::Vector3d normal3(Random& random, double sigma) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return sigma * Eigen::Vector3d(x, y, z);
}

Eigen::Quaterniond exponential(const Eigen::Vector3d& w) {
  return w.norm() > 0 ? Eigen::Quaterniond(Eigen::AngleAxisd(w.norm(), w.normalized()))
                      : Eigen::Quaterniond::Identity();
}

Drive simulate(std::uint64_t seed, const DriveNoise& noise, int poses = 30, int landmarks = 40) {
  constexpr double kStep_m = 2;
  Random random(seed);
  Drive drive;
  Eigen::Isometry3d T_0_sensor = poseFromYaw({3, -4, 1.5}, 0.4);  // odometry starts anywhere
  drive.T_map_query = poseFromYaw({200, 100, 3}, 2.0);
  for (int i = 0; i < poses; ++i) {
    drive.T_map_sensor.push_back(drive.T_map_query * T_0_sensor);
    T_0_sensor = T_0_sensor * poseFromYaw({kStep_m, 0, 0}, 0.03);
    const Eigen::Isometry3d& T = drive.T_map_sensor.back();
    if (i == 0) {
      drive.T_odom_sensor.push_back(drive.T_map_query.inverse() * T);
      continue;
    }
    Eigen::Isometry3d step = drive.T_map_sensor[static_cast<std::size_t>(i) - 1].inverse() * T;
    const double root = std::sqrt(kStep_m);
    step.translation() += normal3(random, noise.odometry_m * root);
    step.rotate(exponential(normal3(random, noise.odometry_rad * root)));
    drive.T_odom_sensor.push_back(drive.T_odom_sensor.back() * step);
  }
  for (int j = 0; j < landmarks; ++j) {
    const auto i = static_cast<std::size_t>(j * poses / landmarks);
    const Eigen::Vector3d p_sensor(random.uniform(-1, 1), random.uniform(-15, 15),
                                   random.uniform(-2, 8));
    const Eigen::Vector3d p = drive.T_map_sensor[i] * p_sensor;
    MatchedVertex vertex;
    vertex.p_odom = drive.T_odom_sensor[i] * (p_sensor + normal3(random, noise.vertex_m));
    vertex.first_pose = vertex.last_pose = i;
    vertex.p_map = p + normal3(random, noise.match_m);
    drive.vertices.push_back(vertex);
  }
  return drive;
}

Eigen::Matrix<double, 6, 1> errorOf(const Eigen::Isometry3d& truth, const Eigen::Isometry3d& T) {
  Eigen::Matrix<double, 6, 1> error;
  const Eigen::AngleAxisd w(Eigen::Matrix3d(truth.linear() * T.linear().transpose()));
  error << truth.translation() - T.translation(), w.angle() * w.axis();
  return error;
}

PosteriorOptions quadratic() {
  PosteriorOptions options;
  options.model.robust_scale = 0;
  options.gravity = "free";
  return options;
}

DriveNoise noiseOf(const PosteriorOptions& options) {
  return {options.odometry_sigma_m, options.odometry_sigma_rad, options.model.vertex_sigma_m,
          options.model.match_sigma_m};
}

TEST(Posterior, OfPerfectDataIsTheTruth) {
  const Drive drive = simulate(1, {});
  for (const char* gravity : {"free", "aligned", "auto"}) {
    PosteriorOptions options;
    options.gravity = gravity;
    const Eigen::Isometry3d start = poseFromYaw({0.8, -0.5, 0.3}, 0.0) * drive.T_map_query *
                                    poseFromYaw(Eigen::Vector3d::Zero(), 0.05);
    const Posterior result = maximizePosterior(drive.T_odom_sensor, drive.vertices, start, options);
    ASSERT_TRUE(result.converged) << result.problem;
    ASSERT_EQ(result.T_map_sensor.size(), 30u);
    for (std::size_t i = 0; i < 30; ++i) {
      EXPECT_TRUE(result.T_map_sensor[i].isApprox(drive.T_map_sensor[i], 1e-6)) << i;
    }
    EXPECT_LT(result.cost_after, 1e-6);
    EXPECT_GT(result.cost_before, 1);
  }
}

TEST(Posterior, RemovesTheDriftOfTheLastPose) {
  double drifted = 0, refined = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Drive drive = simulate(seed, {0.05, 0.01, 0.1, 0.3});
    PosteriorOptions options;
    options.odometry_sigma_rad = 0.01;
    const Posterior result =
        maximizePosterior(drive.T_odom_sensor, drive.vertices, drive.T_map_query, options);
    ASSERT_TRUE(result.converged) << result.problem;
    const Eigen::Vector3d truth = drive.T_map_sensor.back().translation();
    drifted += ((drive.T_map_query * drive.T_odom_sensor.back()).translation() - truth).norm();
    refined += (result.T_map_sensor.back().translation() - truth).norm();
  }
  EXPECT_LT(refined, drifted / 4);
}

/// Calls take(error, covariance) with those of the last pose of simulated drives.
template <class Take>
void forRuns(int runs, const PosteriorOptions& options, Take&& take) {
  for (int run = 0; run < runs; ++run) {
    const Drive drive = simulate(static_cast<std::uint64_t>(100 + run), noiseOf(options));
    const Posterior result =
        maximizePosterior(drive.T_odom_sensor, drive.vertices, drive.T_map_query, options);
    ASSERT_TRUE(result.converged) << result.problem;
    take(errorOf(drive.T_map_sensor.back(), result.T_map_sensor.back()), result.covariance);
  }
}

TEST(Posterior, HasACovarianceThatExplainsItsErrors) {
  // The normalized squared error of the last pose has mean 6 if the covariance is right.
  double sum = 0;
  Eigen::Matrix<double, 6, 1> by_axis = Eigen::Matrix<double, 6, 1>::Zero();
  constexpr int kRuns = 300;
  forRuns(kRuns, quadratic(), [&](const auto& error, const Matrix6d& covariance) {
    sum += error.dot(covariance.ldlt().solve(error));
    by_axis += error.cwiseAbs2().cwiseQuotient(covariance.diagonal());
  });
  EXPECT_NEAR(sum / kRuns, 6, 1.2);
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(by_axis[k] / kRuns, 1, 0.35) << "axis " << k;
}

TEST(Posterior, WithRobustLossKeepsItsCovarianceRoughlyRight) {
  PosteriorOptions options;
  options.gravity = "free";
  double sum = 0;
  constexpr int kRuns = 200;
  forRuns(kRuns, options, [&](const auto& error, const Matrix6d& covariance) {
    sum += error.dot(covariance.ldlt().solve(error));
  });
  EXPECT_NEAR(sum / kRuns, 6, 2.4);
}

TEST(Posterior, WithRobustLossWithstandsWrongMatches) {
  Drive drive = simulate(5, {0.02, 0.001, 0.05, 0.1});
  for (std::size_t j = 0; j < drive.vertices.size(); j += 5) {
    drive.vertices[j].p_map += Eigen::Vector3d(6, -4, 0);
  }
  const auto error = [&](const PosteriorOptions& options) {
    const Posterior result =
        maximizePosterior(drive.T_odom_sensor, drive.vertices, drive.T_map_query, options);
    EXPECT_TRUE(result.converged) << result.problem;
    return errorOf(drive.T_map_sensor.back(), result.T_map_sensor.back()).head<3>().norm();
  };
  PosteriorOptions robust, plain;
  plain.model.robust_scale = 0;
  EXPECT_LT(error(robust), 0.25);
  EXPECT_GT(error(plain), 3 * error(robust));
}

TEST(Posterior, GaussNewtonReachesTheSameOptimumFromRightMatchesForAnyHeading) {
  PosteriorOptions trust_region = quadratic(), gauss_newton = quadratic();
  gauss_newton.solver = "gauss_newton";
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Drive drive = simulate(seed, noiseOf(trust_region));
    const double yaw_rad = 0.3 * static_cast<double>(seed);  // the paper starts with parallel axes
    const Eigen::Isometry3d turn = poseFromYaw({7, 8, 9}, yaw_rad);
    for (auto& vertex : drive.vertices) vertex.p_map = turn * vertex.p_map;
    const Posterior a = maximizePosterior(drive.T_odom_sensor, drive.vertices,
                                          turn * drive.T_map_query, trust_region);
    const Posterior b = maximizePosterior(drive.T_odom_sensor, drive.vertices,
                                          Eigen::Isometry3d::Identity(), gauss_newton);
    ASSERT_TRUE(a.converged) << a.problem;
    ASSERT_TRUE(b.converged) << b.problem;
    EXPECT_NEAR(a.cost_after, b.cost_after, 1e-5 * a.cost_after);
    EXPECT_LT((a.T_map_sensor.back().translation() - b.T_map_sensor.back().translation()).norm(),
              1e-3);
    EXPECT_LT(rotationBetween(a.T_map_sensor.back(), b.T_map_sensor.back()), 1e-4);
  }
}

TEST(Posterior, IsEquivariantToMotionOfTheQuery) {
  const PosteriorOptions options;
  const Drive drive = simulate(3, noiseOf(options));
  const Eigen::Isometry3d motion = poseFromYaw({-40, 30, 2}, 1.2);
  Drive moved = drive;
  for (auto& T : moved.T_odom_sensor) T = motion * T;
  for (auto& vertex : moved.vertices) vertex.p_odom = motion * vertex.p_odom;
  const Posterior a =
      maximizePosterior(drive.T_odom_sensor, drive.vertices, drive.T_map_query, options);
  const Posterior b = maximizePosterior(moved.T_odom_sensor, moved.vertices,
                                        drive.T_map_query * motion.inverse(), options);
  ASSERT_TRUE(a.converged && b.converged);
  EXPECT_TRUE(a.T_map_sensor.back().isApprox(b.T_map_sensor.back(), 1e-6));
  EXPECT_TRUE(a.covariance.isApprox(b.covariance, 1e-4));
}

TEST(Posterior, KnownGravityTightensTheTilt) {
  PosteriorOptions free, aligned;
  free.gravity = "free";
  aligned.gravity = "aligned";
  const Drive drive = simulate(4, noiseOf(free), 5, 6);
  const auto tilt = [&](const PosteriorOptions& options) {
    const Posterior result =
        maximizePosterior(drive.T_odom_sensor, drive.vertices, drive.T_map_query, options);
    EXPECT_TRUE(result.converged) << result.problem;
    return result.covariance(3, 3) + result.covariance(4, 4);
  };
  EXPECT_LT(tilt(aligned), 0.5 * tilt(free));
  EXPECT_LT(tilt(aligned), 2.5 * aligned.model.gravity_sigma_rad * aligned.model.gravity_sigma_rad);
}

TEST(Posterior, CarriesThinnedPosesAlong) {
  const Drive drive = simulate(6, {}, 150, 40);
  PosteriorOptions options;
  options.model.max_poses = 20;
  const Eigen::Isometry3d start = poseFromYaw({0.4, 0.2, 0.1}, 0) * drive.T_map_query;
  const Posterior result = maximizePosterior(drive.T_odom_sensor, drive.vertices, start, options);
  ASSERT_TRUE(result.converged) << result.problem;
  ASSERT_EQ(result.T_map_sensor.size(), 150u);
  for (std::size_t i = 0; i < 150; ++i) {
    EXPECT_TRUE(result.T_map_sensor[i].isApprox(drive.T_map_sensor[i], 1e-6)) << i;
  }
}

TEST(Posterior, OfASinglePoseIsTheAlignmentOfItsVertices) {
  const Drive drive = simulate(7, {0, 0, 0.05, 0.1}, 1, 8);
  const Posterior result =
      maximizePosterior(drive.T_odom_sensor, drive.vertices, drive.T_map_query, {});
  ASSERT_TRUE(result.converged) << result.problem;
  EXPECT_LT(errorOf(drive.T_map_sensor[0], result.T_map_sensor[0]).head<3>().norm(), 0.3);
}

TEST(Posterior, ReportsMatchesThatLeaveThePoseOpen) {
  const Drive drive = simulate(8, {});
  const auto problemOf = [&](std::size_t matches, const PosteriorOptions& options) {
    const std::vector<MatchedVertex> few(drive.vertices.begin(),
                                         drive.vertices.begin() + static_cast<long>(matches));
    const Posterior result =
        maximizePosterior(drive.T_odom_sensor, few, drive.T_map_query, options);
    EXPECT_EQ(result.converged, result.problem.empty());
    return result.problem;
  };
  PosteriorOptions free, aligned;
  free.gravity = "free";
  aligned.gravity = "aligned";
  EXPECT_EQ(problemOf(0, free), "no matched vertices");
  EXPECT_EQ(problemOf(1, free), "1 matches leave the pose open");
  EXPECT_EQ(problemOf(2, free), "2 matches leave the pose open");
  EXPECT_EQ(problemOf(4, free), "");
  EXPECT_EQ(problemOf(1, aligned), "1 matches leave the pose open");
  EXPECT_EQ(problemOf(2, aligned), "");
}

TEST(Posterior, ReportsCollinearMatches) {
  Drive drive = simulate(8, {}, 3, 0);
  for (int j = 0; j < 6; ++j) {
    MatchedVertex vertex;
    vertex.p_odom = Eigen::Vector3d(2.0 * j, 1.0 * j, 0.5 * j);
    vertex.last_pose = 2;
    vertex.p_map = drive.T_map_query * vertex.p_odom;
    drive.vertices.push_back(vertex);
  }
  PosteriorOptions options;
  options.gravity = "free";
  EXPECT_FALSE(
      maximizePosterior(drive.T_odom_sensor, drive.vertices, drive.T_map_query, options).converged);
}

TEST(Posterior, ReportsInputThatIsNotFinite) {
  const Drive drive = simulate(9, {});
  const auto nan = std::numeric_limits<double>::quiet_NaN();
  Drive bad = drive;
  bad.vertices[3].p_map.x() = nan;
  EXPECT_EQ(maximizePosterior(bad.T_odom_sensor, bad.vertices, bad.T_map_query, {}).problem,
            "matched vertex 3 is not finite");
  bad = drive;
  bad.T_odom_sensor[2].translation().y() = nan;
  EXPECT_EQ(maximizePosterior(bad.T_odom_sensor, bad.vertices, bad.T_map_query, {}).problem,
            "pose 2 is not finite");
  bad = drive;
  bad.vertices[0].map_covariance(1, 1) = -1;
  EXPECT_FALSE(maximizePosterior(bad.T_odom_sensor, bad.vertices, bad.T_map_query, {}).converged);
  EXPECT_EQ(maximizePosterior({}, drive.vertices, drive.T_map_query, {}).problem, "no poses");
}

TEST(Posterior, IsRepeatable) {
  const Drive drive = simulate(10, noiseOf({}));
  const Posterior a = maximizePosterior(drive.T_odom_sensor, drive.vertices, drive.T_map_query, {});
  const Posterior b = maximizePosterior(drive.T_odom_sensor, drive.vertices, drive.T_map_query, {});
  ASSERT_TRUE(a.converged);
  EXPECT_EQ(a.T_map_sensor.back().matrix(), b.T_map_sensor.back().matrix());
  EXPECT_EQ(a.covariance, b.covariance);
}

}  // namespace
}  // namespace xview::pose
