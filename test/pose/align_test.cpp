// SPDX-License-Identifier: BSD-3-Clause
#include "pose/align.h"

#include <gtest/gtest.h>

#include <limits>

#include "base/pose.h"
#include "base/random.h"

namespace xview::pose {
namespace {

using Points = std::vector<Eigen::Vector3d>;

Points randomPoints(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  Points points(count);
  for (auto& p : points) {
    p = {random.uniform(-30, 30), random.uniform(-30, 30), random.uniform(-5, 5)};
  }
  return points;
}

Points moved(const Points& points, const Eigen::Isometry3d& T) {
  Points result;
  for (const auto& p : points) result.push_back(T * p);
  return result;
}

Points noisy(Points points, double sigma_m, std::uint64_t seed) {
  Random random(seed);
  for (auto& p : points) {
    p += sigma_m * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
  }
  return points;
}

Eigen::Isometry3d tilted() {
  Eigen::Isometry3d T = poseFromYaw({100, -50, 7}, 2.5);
  T.rotate(Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, 2, -1).normalized()));
  return T;
}

double cost(const Points& source, const Points& target, const Eigen::Isometry3d& T) {
  double sum = 0;
  for (std::size_t i = 0; i < source.size(); ++i) sum += (target[i] - T * source[i]).squaredNorm();
  return sum;
}

TEST(AlignPoints, RecoversAnyMotionExactly) {
  const Points source = randomPoints(10, 1);
  const Alignment result = alignPoints(source, moved(source, tilted()));
  ASSERT_TRUE(result.valid) << result.problem;
  EXPECT_TRUE(result.T_target_source.isApprox(tilted(), 1e-12));
  EXPECT_LT(result.rms_m, 1e-12);
}

TEST(AlignPoints, RecoversThreePointsInAPlane) {
  const Points source{{0, 0, 0}, {5, 0, 0}, {0, 3, 0}};
  const Alignment result = alignPoints(source, moved(source, tilted()));
  ASSERT_TRUE(result.valid) << result.problem;
  EXPECT_TRUE(result.T_target_source.isApprox(tilted(), 1e-9));
}

TEST(AlignPoints, MinimisesTheCost) {
  Random random(3);
  const Points source = randomPoints(12, 1), target = noisy(moved(source, tilted()), 1.0, 2);
  const Alignment result = alignPoints(source, target);
  ASSERT_TRUE(result.valid);
  const double best = cost(source, target, result.T_target_source);
  for (int i = 0; i < 200; ++i) {
    Eigen::Isometry3d other = result.T_target_source;
    const Eigen::Vector3d axis(random.normal(), random.normal(), random.normal());
    other.rotate(Eigen::AngleAxisd(1e-3 * random.normal(), axis.normalized()));
    other.translation() += 1e-2 * Eigen::Vector3d(random.normal(), random.normal(), 0);
    EXPECT_GE(cost(source, target, other), best);
  }
  EXPECT_NEAR(result.rms_m, std::sqrt(best / 12), 1e-12);
}

TEST(AlignPoints, KeepsItsPrecisionFarFromTheOrigin) {
  Eigen::Isometry3d far = tilted();
  far.translation() += Eigen::Vector3d(500000, 4649776, 300);
  const Points source = randomPoints(10, 1);
  const Alignment result = alignPoints(source, moved(source, far));
  ASSERT_TRUE(result.valid);
  EXPECT_LT((result.T_target_source.translation() - far.translation()).norm(), 1e-7);
}

TEST(AlignPoints, NeverReflects) {
  const Points source = randomPoints(10, 1);
  Points mirror = source;
  for (auto& p : mirror) p.x() = -p.x();
  const Alignment result = alignPoints(source, mirror);
  ASSERT_TRUE(result.valid) << result.problem;
  EXPECT_NEAR(result.T_target_source.linear().determinant(), 1, 1e-12);
  EXPECT_GT(result.rms_m, 1);
}

TEST(AlignPoints, IsEquivariantToMotionOfEitherSide) {
  const Points source = randomPoints(9, 4), target = noisy(moved(source, tilted()), 0.5, 5);
  const Eigen::Isometry3d A = poseFromYaw({3, 4, 5}, -1), B = tilted();
  const Alignment plain = alignPoints(source, target);
  const Alignment both = alignPoints(moved(source, A), moved(target, B));
  ASSERT_TRUE(plain.valid && both.valid);
  EXPECT_TRUE(both.T_target_source.isApprox(B * plain.T_target_source * A.inverse(), 1e-9));
  EXPECT_NEAR(plain.rms_m, both.rms_m, 1e-9);
}

TEST(AlignPoints, ReportsTooFewCollinearAndCoincidentPoints) {
  const Points two{{0, 0, 0}, {1, 0, 0}}, four = randomPoints(4, 1);
  EXPECT_FALSE(alignPoints({}, {}).valid);
  EXPECT_EQ(alignPoints(two, two).problem, "2 points, at least 3 are needed");
  const Points line{{0, 0, 0}, {1, 1, 0}, {2, 2, 0}, {5, 5, 0}};
  EXPECT_EQ(alignPoints(line, line).problem, "source points are collinear");
  EXPECT_EQ(alignPoints(four, line).problem, "target points are collinear");
  const Points same(4, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(alignPoints(same, four).problem, "source points coincide");
}

TEST(AlignPoints, ReportsWrongInput) {
  const Points four = randomPoints(4, 1);
  Points bad = four;
  bad[2].z() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(alignPoints(four, bad).problem, "point 2 is not finite");
  EXPECT_EQ(alignPoints(four, randomPoints(3, 1)).problem, "4 source points for 3 target points");
}

TEST(AlignPointsInYaw, RecoversYawAndPositionFromTwoPoints) {
  const Points source{{0, 0, 0}, {5, 1, 2}};
  const Eigen::Isometry3d T = poseFromYaw({10, 20, 30}, -2);
  const Alignment result = alignPointsInYaw(source, moved(source, T));
  ASSERT_TRUE(result.valid) << result.problem;
  EXPECT_TRUE(result.T_target_source.isApprox(T, 1e-12));
}

TEST(AlignPointsInYaw, KeepsZUprightAndBeatsEveryOtherYaw) {
  const Points source = randomPoints(10, 1);
  const Points target = noisy(moved(source, poseFromYaw({1, 2, 3}, 1)), 2.0, 7);
  const Alignment result = alignPointsInYaw(source, target);
  ASSERT_TRUE(result.valid);
  EXPECT_TRUE((result.T_target_source.linear() * Eigen::Vector3d::UnitZ())
                  .isApprox(Eigen::Vector3d::UnitZ(), 1e-15));
  const double best = cost(source, target, result.T_target_source);
  for (int i = 1; i < 60; ++i) {
    // The best translation for another yaw keeps the centroids together.
    Eigen::Vector3d from = Eigen::Vector3d::Zero(), to = from;
    for (int k = 0; k < 10; ++k) {
      from += source[k] / 10;
      to += target[k] / 10;
    }
    Eigen::Isometry3d other =
        poseFromYaw(Eigen::Vector3d::Zero(), yawOf(result.T_target_source.linear()) + 0.1 * i);
    other.translation() = to - other.linear() * from;
    EXPECT_GT(cost(source, target, other), best);
  }
}

TEST(AlignPointsInYaw, AcceptsCollinearPointsButNotOneAboveTheOther) {
  const Points line{{0, 0, 0}, {1, 1, 0}, {2, 2, 0}};
  EXPECT_TRUE(alignPointsInYaw(line, line).valid);
  const Points mast{{1, 1, 0}, {1, 1, 5}};
  EXPECT_EQ(alignPointsInYaw(mast, mast).problem, "points coincide in the plane");
  EXPECT_FALSE(alignPointsInYaw({{0, 0, 0}}, {{0, 0, 0}}).valid);
}

TEST(AlignPointsInYaw, ReportsAnUndeterminedYaw) {
  // Turning the target by any angle fits equally badly: a cross against its mirror image.
  const Points cross{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}};
  const Points mirror{{1, 0, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 1, 0}};
  EXPECT_EQ(alignPointsInYaw(cross, mirror).problem, "the yaw is not determined by these points");
}

}  // namespace
}  // namespace xview::pose
