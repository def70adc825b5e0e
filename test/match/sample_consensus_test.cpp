// SPDX-License-Identifier: BSD-3-Clause
#include "match/sample_consensus.h"

#include <gtest/gtest.h>
#include <pcl/console/print.h>

#include <cmath>
#include <limits>
#include <thread>

#include "base/pose.h"
#include "base/random.h"

namespace xview::match {
namespace {

using Points = std::vector<Eigen::Vector3d>;

/// Query points, the map points they become, and correspondences of which some are true.
struct Problem {
  Points query, map;
  std::vector<Correspondence> correspondences;
  Eigen::Isometry3d T_map_query = Eigen::Isometry3d::Identity();
  int true_ones = 0;
};

Problem makeProblem(int points, double inlier_share, double noise_m, std::uint64_t seed,
                    const Eigen::Vector3d& map_origin = {300, -200, 10}) {
  Random random(seed);
  Problem problem;
  problem.T_map_query = poseFromYaw(map_origin, 2.3);
  problem.T_map_query.rotate(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitX()));
  for (int i = 0; i < points; ++i) {
    const Eigen::Vector3d p(random.uniform(0, 60), random.uniform(0, 60), random.uniform(0, 5));
    const Eigen::Vector3d noise =
        noise_m * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
    problem.query.push_back(p);
    if (random.uniform() < inlier_share) {
      problem.map.push_back(problem.T_map_query * p + noise);
      ++problem.true_ones;
    } else {
      const Eigen::Vector3d elsewhere(random.uniform(0, 300), random.uniform(0, 300), 0);
      problem.map.push_back(map_origin + elsewhere);
    }
    const auto index = static_cast<std::uint32_t>(i);
    problem.correspondences.push_back({index, index, 0.5f});
  }
  return problem;
}

Consensus solve(const Problem& p, const ConsensusOptions& options = {}) {
  return rejectBySampleConsensus(p.query, p.map, p.correspondences, options);
}

/// What is left between the inliers [m].
double rmsOf(const Problem& problem, const Consensus& consensus) {
  double sum = 0;
  for (const Correspondence& c : consensus.inliers)
    sum += (problem.map[c.map] - consensus.T_map_query * problem.query[c.query]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(consensus.inliers.size()));
}

TEST(SampleConsensus, FindsThePoseAmongHalfOutliers) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const Problem problem = makeProblem(80, 0.5, 0.2, seed);
    const Consensus consensus = solve(problem);
    ASSERT_TRUE(consensus.found);
    EXPECT_LT(rotationBetween(consensus.T_map_query, problem.T_map_query), 0.02);
    const Eigen::Vector3d middle(30, 30, 2);
    EXPECT_LT((consensus.T_map_query * middle - problem.T_map_query * middle).norm(), 0.3);
    EXPECT_NEAR(static_cast<double>(consensus.inliers.size()), problem.true_ones, 2);
    EXPECT_LT(rmsOf(problem, consensus), 0.8);
    EXPECT_TRUE(isRigid(consensus.T_map_query.matrix(), 1e-9));
  }
}

TEST(SampleConsensus, TellsTargetsOfOneQueryVertexApart) {
  // Three candidates each, the true one first or in the middle: the library keeps one target per
  // source index, so it would see the last one only.
  Problem problem = makeProblem(30, 1.0, 0.1, 3);
  Random random(8);
  std::vector<Correspondence> candidates;
  for (std::uint32_t i = 0; i < 30; ++i) {
    for (int wrong = 0; wrong < 2; ++wrong) {
      if (wrong == static_cast<int>(i % 2)) candidates.push_back({i, i, 0.5f});
      const auto other = static_cast<std::uint32_t>(problem.map.size());
      problem.map.push_back({300 + random.uniform(0, 300), random.uniform(-300, 0), 10});
      candidates.push_back({i, other, 0.5f});
    }
  }
  problem.correspondences = candidates;
  const Consensus consensus = solve(problem);
  ASSERT_TRUE(consensus.found);
  EXPECT_GE(consensus.inliers.size(), 29u);
}

TEST(SampleConsensus, DoesNotTakeFailureForSuccess) {
  // Nothing but outliers: the library answers with all of them and identity.
  ConsensusOptions options;
  options.inlier_m = 0.5;
  options.min_inliers = 6;
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    EXPECT_FALSE(solve(makeProblem(60, 0.0, 0, seed), options).found);
  }
}

TEST(SampleConsensus, IsSilentAboutFailureAndLeavesTheVerbosityOfPclAlone) {
  ConsensusOptions options;
  options.inlier_m = 0.001;
  options.iterations = 50;
  const auto level = pcl::console::getVerbosityLevel();
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  EXPECT_FALSE(solve(makeProblem(60, 0.0, 0, 1), options).found);
  // Two clumps: no three points far enough apart to draw.
  Problem clumps = makeProblem(10, 1, 0, 1);
  for (std::size_t i = 0; i < 10; ++i) {
    clumps.query[i] = {i % 2 == 0 ? 0.0 : 100.0, 1e-3 * static_cast<double>(i), 0};
  }
  EXPECT_FALSE(solve(clumps, options).found);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(pcl::console::getVerbosityLevel(), level);
}

TEST(SampleConsensus, FindsIdentityWhereItIsTheTruth) {
  Problem problem = makeProblem(20, 1, 0, 1);
  problem.map = problem.query;
  const Consensus consensus = solve(problem);
  ASSERT_TRUE(consensus.found);
  EXPECT_TRUE(consensus.T_map_query.isApprox(Eigen::Isometry3d::Identity(), 1e-6));
  EXPECT_EQ(consensus.inliers.size(), 20u);
}

TEST(SampleConsensus, KeepsMillimetresInMapCoordinatesOfMillions) {
  const Problem problem = makeProblem(40, 1.0, 0.0, 5, {500000, 4649776, 300});
  const Consensus consensus = solve(problem);
  ASSERT_TRUE(consensus.found);
  EXPECT_LT(rmsOf(problem, consensus), 1e-3);
}

TEST(SampleConsensus, RefusesAMirrorImage) {
  // Pair distances agree in full, and yet no rotation does it.
  Problem problem = makeProblem(40, 1.0, 0.0, 5);
  for (std::size_t i = 0; i < problem.map.size(); ++i) {
    problem.query[i].z() *= 6;
    problem.map[i] = problem.query[i].cwiseProduct(Eigen::Vector3d(-1, 1, 1));
  }
  ConsensusOptions options;
  options.inlier_m = 0.5;
  options.min_inliers = 20;
  EXPECT_FALSE(solve(problem, options).found);
}

TEST(SampleConsensus, IsRepeatableAlsoInAnotherThread) {
  const Problem problem = makeProblem(200, 0.25, 0.3, 11);
  const Consensus a = solve(problem), b = solve(problem);
  Consensus c;
  std::thread([&] { c = solve(problem); }).join();
  ASSERT_TRUE(a.found);
  EXPECT_EQ(a.T_map_query.matrix(), b.T_map_query.matrix());
  EXPECT_EQ(a.T_map_query.matrix(), c.T_map_query.matrix());
}

TEST(SampleConsensus, EmptyTooFewCoincidentAndNotFiniteAreNoPose) {
  EXPECT_FALSE(rejectBySampleConsensus({}, {}, {}, {}).found);
  const Problem two = makeProblem(2, 1, 0, 1);
  EXPECT_FALSE(solve(two).found);
  Problem coincident = makeProblem(10, 1, 0, 1);
  for (auto& p : coincident.query) p = {1, 2, 3};
  EXPECT_FALSE(solve(coincident).found);
  Problem not_finite = makeProblem(10, 1, 0, 1);
  for (auto& p : not_finite.map) p.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(solve(not_finite).found);
}

TEST(SampleConsensus, IgnoresPointsThatAreNotFinite) {
  Problem problem = makeProblem(30, 1, 0.1, 2);
  problem.query[4].y() = std::numeric_limits<double>::quiet_NaN();
  problem.map[9].z() = std::numeric_limits<double>::infinity();
  const Consensus consensus = solve(problem);
  ASSERT_TRUE(consensus.found);
  EXPECT_EQ(consensus.inliers.size(), 28u);
}

TEST(Supporters, UseEachVertexOnceNearestFirst) {
  const Points query{{0, 0, 0}, {10, 0, 0}}, map{{0.5, 0, 0}, {0.1, 0, 0}, {10.2, 0, 0}};
  const std::vector<Correspondence> all{{0, 0, 1}, {0, 1, 1}, {1, 1, 1}, {1, 2, 1}};
  const auto kept = supporters(query, map, all, Eigen::Isometry3d::Identity(), 1);
  ASSERT_EQ(kept.size(), 2u);
  EXPECT_EQ(kept[0].query, 0u);
  EXPECT_EQ(kept[0].map, 1u);
  EXPECT_EQ(kept[1].query, 1u);
  EXPECT_EQ(kept[1].map, 2u);
}

TEST(Supporters, ShareNoMapVertexEither) {
  const Points query{{0, 0, 0}, {0.5, 0, 0}}, map{{0.4, 0, 0}};
  const auto kept =
      supporters(query, map, {{0, 0, 1}, {1, 0, 1}}, Eigen::Isometry3d::Identity(), 1);
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_EQ(kept[0].query, 1u) << "the nearer one";
}

TEST(Supporters, AreThoseWithinTheDistanceInclusive) {
  const Points query{{0, 0, 0}, {5, 0, 0}}, map{{1, 0, 0}, {6.001, 0, 0}};
  const std::vector<Correspondence> all{{0, 0, 1}, {1, 1, 1}};
  EXPECT_EQ(supporters(query, map, all, Eigen::Isometry3d::Identity(), 1).size(), 1u);
}

}  // namespace
}  // namespace xview::match
