// SPDX-License-Identifier: BSD-3-Clause
#include "match/consistency.h"

#include <gtest/gtest.h>

#include <limits>

#include "base/pose.h"
#include "base/random.h"
#include "match/sample_consensus.h"

namespace xview::match {
namespace {

using Points = std::vector<Eigen::Vector3d>;

Points randomPoints(std::size_t count, double size_m, std::uint64_t seed) {
  Random random(seed);
  Points points(count);
  for (auto& p : points)
    p = {random.uniform(0, size_m), random.uniform(0, size_m), random.uniform(0, 5)};
  return points;
}

/// Sixty query vertices with fifteen partners each, 12 of 900 of them true.
struct Problem {
  Points query = randomPoints(60, 60, 1), map = randomPoints(700, 400, 2);
  std::vector<Correspondence> correspondences;
  std::vector<Correspondence> true_ones;

  explicit Problem(const Eigen::Isometry3d& T_map_query, double noise_m = 0.3) {
    Random random(3);
    for (std::uint32_t q = 0; q < 60; ++q) {
      for (int k = 0; k < 15; ++k) correspondences.push_back({q, random.below(700), 0.5f});
      if (q % 5 != 0) continue;
      map[10 * q] = T_map_query * query[q] +
                    noise_m * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
      correspondences.back().map = 10 * q;
      true_ones.push_back(correspondences.back());
    }
  }

  int countTrue(const std::vector<Correspondence>& found) const {
    int count = 0;
    for (const Correspondence& c : found) count += c.map == 10 * c.query;
    return count;
  }
};

TEST(ConsistentCorrespondences, FindTheFewThatOnePoseExplains) {
  const Problem problem(poseFromYaw({150, 100, 3}, 1.0));
  const auto found =
      consistentCorrespondences(problem.query, problem.map, problem.correspondences, 2, true);
  EXPECT_EQ(problem.countTrue(found), 12);
  EXPECT_LT(found.size(), 40u);
  const Consensus blind =
      rejectBySampleConsensus(problem.query, problem.map, problem.correspondences, {2, 10000, 4});
  EXPECT_LT(problem.countTrue(blind.inliers), 12);
  EXPECT_EQ(problem.countTrue(
                rejectBySampleConsensus(problem.query, problem.map, found, {2, 10000, 4}).inliers),
            12);
}

TEST(ConsistentCorrespondences, FindThemWhicheverWayIsUp) {
  Eigen::Isometry3d T = poseFromYaw({150, 100, 3}, 1.0);
  T.rotate(Eigen::AngleAxisd(0.8, Eigen::Vector3d::UnitX()));
  const Problem problem(T);
  EXPECT_EQ(problem.countTrue(consistentCorrespondences(problem.query, problem.map,
                                                        problem.correspondences, 2, false)),
            12);
  EXPECT_LT(problem.countTrue(consistentCorrespondences(problem.query, problem.map,
                                                        problem.correspondences, 2, true)),
            8);
}

TEST(ConsistentCorrespondences, KeepTheOrderGiven) {
  const Problem problem(poseFromYaw({150, 100, 3}, 1.0));
  std::vector<Correspondence> reversed(problem.correspondences.rbegin(),
                                       problem.correspondences.rend());
  const auto forward =
      consistentCorrespondences(problem.query, problem.map, problem.correspondences, 2, true);
  const auto backward = consistentCorrespondences(problem.query, problem.map, reversed, 2, true);
  EXPECT_EQ(problem.countTrue(backward), 12);
  for (std::size_t i = 1; i < forward.size(); ++i)
    EXPECT_LE(forward[i - 1].query, forward[i].query);
  for (std::size_t i = 1; i < backward.size(); ++i)
    EXPECT_GE(backward[i - 1].query, backward[i].query);
}

TEST(ConsistentCorrespondences, TakeTheFirstOfEveryVertexWhereTheyAreTooMany) {
  Problem problem(poseFromYaw({150, 100, 3}, 1.0));
  Random random(7);
  std::vector<Correspondence> many = problem.true_ones;
  for (std::uint32_t q = 0; q < 60; ++q) {
    for (int k = 0; k < 200; ++k) many.push_back({q, random.below(700), 0.1f});
  }
  const auto found = consistentCorrespondences(problem.query, problem.map, many, 2, true);
  EXPECT_GE(problem.countTrue(found), 12);
}

TEST(ConsistentCorrespondences, LeaveOutWhatIsNotFinite) {
  Problem problem(poseFromYaw({150, 100, 3}, 1.0));
  problem.query[5].y() = std::numeric_limits<double>::quiet_NaN();
  problem.map[100].x() = std::numeric_limits<double>::infinity();
  const auto found =
      consistentCorrespondences(problem.query, problem.map, problem.correspondences, 2, true);
  EXPECT_EQ(problem.countTrue(found), 10);
}

TEST(ConsistentCorrespondences, AreNoneWhereNoThreeAgree) {
  EXPECT_TRUE(consistentCorrespondences({}, {}, {}, 2, true).empty());
  const Points line{{0, 0, 0}, {10, 0, 0}, {20, 0, 0}}, bent{{0, 0, 0}, {10, 0, 0}, {20, 40, 0}};
  const std::vector<Correspondence> own{{0, 0, 1}, {1, 1, 1}, {2, 2, 1}};
  for (const bool upright : {true, false}) {
    EXPECT_TRUE(consistentCorrespondences(line, bent, own, 2, upright).empty());
    EXPECT_EQ(consistentCorrespondences(bent, bent, own, 2, upright).size(), 3u);
  }
}

}  // namespace
}  // namespace xview::match
