// SPDX-License-Identifier: BSD-3-Clause
#include "match/feature_matching.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "base/pose.h"
#include "base/random.h"
#include "match/consistency.h"

namespace xview::match {
namespace {

using Eigen::Vector3d;

constexpr double kVoxel_m = 0.15, kStep_m = 0.07;

/// Points on the walls of a room of 6 x 5 x 2.6 m and on balls and tilted discs in it, others for
/// another seed, of which those with x in a range were seen; 7 cm apart, with 5 mm of noise.
LabelledCloud room(std::uint64_t seed, double least_x, double most_x, std::uint64_t noise_seed) {
  Random random(seed), noise(noise_seed);
  LabelledCloud cloud;
  const auto see = [&](const Vector3d& p) {
    const Eigen::Vector3f q =
        (p + 0.005 * Vector3d(noise.normal(), noise.normal(), noise.normal())).cast<float>();
    if (q.x() >= least_x && q.x() <= most_x) cloud.points.emplace_back(q.x(), q.y(), q.z(), 0);
  };
  for (double x = 0; x <= 6; x += kStep_m) {
    for (double y = 0; y <= 5; y += kStep_m) see({x, y, 0});
    for (double z = 0; z <= 2.6; z += kStep_m) see({x, 0, z});
  }
  for (double y = 0; y <= 5; y += kStep_m) {
    for (double z = 0; z <= 2.6; z += kStep_m) see({0, y, z});
  }
  for (int i = 0; i < 24; ++i) {
    const Vector3d middle(random.uniform(0.5, 5.5), random.uniform(0.5, 4.5),
                          random.uniform(0.3, 2.2));
    const double radius = random.uniform(0.25, 0.6);
    const Vector3d axis = Vector3d(random.normal(), random.normal(), random.normal()).normalized();
    const int count = static_cast<int>(4 * M_PI * radius * radius / (kStep_m * kStep_m));
    for (int k = 0; k < count; ++k) {
      const Vector3d n = Vector3d(noise.normal(), noise.normal(), noise.normal()).normalized();
      if (i % 2 == 0) {
        see(middle + radius * n);
      } else if (k % 2 == 0) {
        see(middle + radius * std::sqrt(noise.uniform(0, 1)) * axis.cross(n).normalized());
      }
    }
  }
  return cloud;
}

LabelledCloud moved(const LabelledCloud& cloud, const Eigen::Isometry3d& T) {
  LabelledCloud result = cloud;
  for (Point& p : result.points)
    p.getVector3fMap() = (T * p.getVector3fMap().cast<double>()).cast<float>();
  return result;
}

FeatureCloud features(const LabelledCloud& cloud, const Vector3d& seen_from, int threads = 2) {
  return FeatureCloud(cloud, {seen_from}, kVoxel_m, threads);
}

const Vector3d kMiddle(3, 2.5, 1.6);

TEST(FeatureMatching, FindsAPartOfARoomWhicheverWayItIsTurned) {
  const FeatureCloud map = features(room(1, 0, 4.2, 2), kMiddle);
  for (const double angle : {0.4, 3.0}) {
    Eigen::Isometry3d T_query_map(Eigen::AngleAxisd(angle, Vector3d(0.5, -0.3, 0.8).normalized()));
    T_query_map.translation() = Vector3d(40, -7, 3);
    const FeatureCloud query =
        features(moved(room(1, 1.2, 6, 3), T_query_map), T_query_map * kMiddle);
    const auto poses = matchFeatures(query, map, 3);
    ASSERT_FALSE(poses.empty());
    const Eigen::Isometry3d off = poses[0].T_map_query * T_query_map;
    EXPECT_LT((off * kMiddle - kMiddle).norm(), 0.05) << angle;
    EXPECT_LT(rotationBetween(off, Eigen::Isometry3d::Identity()), 0.02) << angle;
    EXPECT_GT(poses[0].share, 0.3);
    for (std::size_t i = 1; i < poses.size(); ++i) EXPECT_LT(poses[i].share, poses[0].share / 1.5);
  }
}

TEST(FeatureMatching, IsTheSameForAnyNumberOfThreads) {
  const LabelledCloud seen = room(1, 1.2, 6, 3), known = room(1, 0, 4.2, 2);
  const auto one = matchFeatures(features(seen, kMiddle, 1), features(known, kMiddle, 1), 3);
  const auto many = matchFeatures(features(seen, kMiddle, 3), features(known, kMiddle, 3), 3);
  ASSERT_EQ(one.size(), many.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].T_map_query.matrix(), many[i].T_map_query.matrix());
    EXPECT_EQ(one[i].share, many[i].share);
  }
}

TEST(FeatureMatching, OfAMirrorImageIsThatOfMirroredPoints) {
  const FeatureCloud map = features(room(1, 0, 4.2, 2), kMiddle);
  const auto flipped = [](LabelledCloud cloud) {
    for (Point& p : cloud.points) p.y *= -1;
    return cloud;
  };
  for (const bool is_mirror_image : {false, true}) {
    LabelledCloud seen = room(1, 1.2, 6, 3);
    Vector3d eye = kMiddle;
    if (is_mirror_image) {
      seen = flipped(seen);
      eye.y() *= -1;
    }
    const auto by_features = matchFeatures(features(seen, eye).mirrored(), map, 1);
    eye.y() *= -1;
    const auto by_points = matchFeatures(features(flipped(seen), eye), map, 1);
    ASSERT_EQ(by_features.empty(), by_points.empty());
    if (by_points.empty()) continue;
    EXPECT_NEAR(by_features[0].share, by_points[0].share, is_mirror_image ? 0.01 : 0.1);
    if (is_mirror_image) {
      EXPECT_GT(by_features[0].share, 0.3);
    }
  }
}

TEST(FeatureMatching, LaysLessOfAnotherRoomOnTheMap) {
  const FeatureCloud map = features(room(1, 0, 4.2, 2), kMiddle);
  const auto own = matchFeatures(features(room(1, 1.2, 6, 3), kMiddle), map, 1);
  const auto other = matchFeatures(features(room(7, 1.2, 6, 3), kMiddle), map, 1);
  ASSERT_EQ(own.size(), 1u);
  for (const FeaturePose& pose : other) EXPECT_LT(pose.share, 0.8 * own[0].share);
}

TEST(FeatureMatching, OfNothingIsNothing) {
  const FeatureCloud map = features(room(1, 0, 4.2, 2), kMiddle);
  EXPECT_TRUE(matchFeatures(features({}, kMiddle), map, 3).empty());
  EXPECT_TRUE(matchFeatures(map, features({}, kMiddle), 3).empty());
  LabelledCloud one;
  one.points.emplace_back(1, 2, 3, 0);
  EXPECT_TRUE(matchFeatures(features(one, kMiddle), map, 3).empty());
  EXPECT_EQ(voxelCount({}, kVoxel_m), 0u);
}

/// Thirty matches of one pose and twenty of another among four hundred of none.
TEST(ConsistentPoses, AreThoseWithMostSupport) {
  Random random(5);
  const auto anywhere = [&] {
    return Vector3d(random.uniform(0, 9), random.uniform(0, 9), random.uniform(0, 9));
  };
  Eigen::Isometry3d first(Eigen::AngleAxisd(2, Vector3d(1, 2, -1).normalized()));
  first.translation() = Vector3d(4, 5, 6);
  Eigen::Isometry3d second(Eigen::AngleAxisd(-1, Vector3d(0, 1, 1).normalized()));
  const auto anyNormal = [&] { return (anywhere() - Vector3d(4.5, 4.5, 4.5)).normalized(); };
  std::vector<PointMatch> matches;
  for (int i = 0; i < 430; ++i) {
    PointMatch match{anywhere(), anywhere(), anyNormal(), anyNormal()};
    if (const Eigen::Isometry3d* T = i % 14 == 0 ? &first : i % 20 == 1 ? &second : nullptr) {
      match.map = *T * match.query;
      match.map_normal = T->linear() * match.query_normal;
    }
    matches.push_back(match);
  }
  const auto poses = consistentPoses(matches, 0.1, 2);
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_TRUE(poses[0].T_map_query.isApprox(first, 1e-6));
  EXPECT_GE(poses[0].support, 30u);
  EXPECT_TRUE(poses[1].T_map_query.isApprox(second, 1e-6));
  EXPECT_TRUE(consistentPoses({}, 0.1, 2).empty());
}

}  // namespace
}  // namespace xview::match
