// SPDX-License-Identifier: BSD-3-Clause
#include "place/blobs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "place/lift.h"
#include "scenes.h"

namespace xview {

namespace {

using namespace test;

void append(LabelledCloud& cloud, const LabelledCloud& more) { cloud.points += more.points; }

/// A box full of points on a 0.2 m lattice.
LabelledCloud box(std::uint32_t label, const Eigen::Vector3f& corner, const Eigen::Vector3i& count,
                  std::uint32_t instance = 0) {
  LabelledCloud cloud;
  for (int i = 0; i < count.prod(); ++i) {
    const Eigen::Vector3i cell(i % count.x(), i / count.x() % count.y(), i / count.x() / count.y());
    const Eigen::Vector3f p = corner + 0.2f * cell.cast<float>();
    cloud.points.push_back(Point(p.x(), p.y(), p.z(), label));
    cloud.points.back().instance = instance;
  }
  return cloud;
}

BlobOptions keepingAll() {
  BlobOptions options;
  options.min_points = 1;
  return options;
}

TEST(Blobs, HaveMeanCovarianceAndBoundsOfTheirPoints) {
  LabelledCloud cloud = cloudOf({{0, 0, 0}, {0.4f, 0, 0}, {0.4f, 0.3f, 0}, {0, 0.3f, 0}}, kBench,
                                Eigen::Vector3d(500000, 4649776, 0));
  const std::vector<Blob> blobs = extractBlobs(cloud, townLabels(), keepingAll());
  ASSERT_EQ(blobs.size(), 1u);
  EXPECT_EQ(blobs[0].label, kBench);
  EXPECT_EQ(blobs[0].points, 4u);
  EXPECT_LT((blobs[0].position - Eigen::Vector3d(500000.2, 4649776.15, 0)).norm(), 1e-6);
  EXPECT_LT((blobs[0].min - Eigen::Vector3d(500000, 4649776, 0)).norm(), 1e-6);
  EXPECT_LT((blobs[0].max - Eigen::Vector3d(500000.4, 4649776.3, 0)).norm(), 1e-6);
  const Eigen::Vector3d variances(0.04, 0.0225, 0);
  EXPECT_LT((blobs[0].covariance - Eigen::Matrix3d(variances.asDiagonal())).norm(), 1e-6);
}

TEST(Blobs, NeverJoinClassesAndLeaveIgnoredOnesOut) {
  LabelledCloud cloud = box(kCar, {0, 0, 0}, {3, 3, 3});
  append(cloud, box(kBench, {0.1f, 0, 0}, {3, 3, 3}));
  append(cloud, box(kSky, {0, 0.1f, 0}, {3, 3, 3}));
  append(cloud, box(99, {0, 0, 0.1f}, {3, 3, 3}));
  std::vector<int> blob_of_point;
  const std::vector<Blob> blobs = extractBlobs(cloud, townLabels(), keepingAll(), &blob_of_point);
  ASSERT_EQ(blobs.size(), 2u);
  EXPECT_EQ(blobs[0].label, kCar);
  EXPECT_EQ(blobs[1].label, kBench);
  std::vector<int> expected(27, 0);
  expected.resize(54, 1);
  expected.resize(108, -1);
  EXPECT_EQ(blob_of_point, expected);
}

TEST(Blobs, AreOrderedByLabelThenByFirstPoint) {
  LabelledCloud cloud = box(kBench, {50, 0, 0}, {2, 2, 2}, 7);
  append(cloud, box(kCar, {0, 0, 0}, {2, 2, 2}));
  append(cloud, box(kBench, {0, 50, 0}, {2, 2, 2}, 3));
  append(cloud, box(kCar, {20, 0, 0}, {2, 2, 2}));
  std::vector<int> blob_of_point;
  const std::vector<Blob> blobs = extractBlobs(cloud, townLabels(), keepingAll(), &blob_of_point);
  ASSERT_EQ(blobs.size(), 4u);
  EXPECT_EQ(blobs[0].position.x(), 0.1f);
  EXPECT_EQ(blobs[1].label, kCar);
  EXPECT_EQ(blobs[2].instance, 7u);
  EXPECT_EQ(blobs[3].instance, 3u);
  for (const auto& [point, blob] :
       std::vector<std::pair<int, int>>{{0, 2}, {8, 0}, {16, 3}, {24, 1}}) {
    EXPECT_EQ(blob_of_point[static_cast<std::size_t>(point)], blob);
  }
}

TEST(Blobs, SeparateTouchingInstances) {
  LabelledCloud cloud = box(kCar, {0, 0, 0}, {4, 4, 4}, 1);
  append(cloud, box(kCar, {0.8f, 0, 0}, {4, 4, 4}, 2));
  append(cloud, box(kCar, {1.6f, 0, 0}, {4, 4, 4}, 0));
  EXPECT_EQ(extractBlobs(cloud, townLabels(), {}).size(), 3u);
  for (Point& point : cloud.points) point.instance = 0;
  const std::vector<Blob> joined = extractBlobs(cloud, townLabels(), {});
  ASSERT_EQ(joined.size(), 1u);
  EXPECT_EQ(joined[0].instance, 0u);
  EXPECT_EQ(joined[0].points, 192u);
}

TEST(Blobs, SmallerThanTheLimitAreDropped) {
  LabelledCloud cloud = box(kPole, {0, 0, 0}, {1, 1, 19});
  append(cloud, box(kPole, {9, 0, 0}, {1, 1, 20}));
  const std::vector<Blob> blobs = extractBlobs(cloud, townLabels(), BlobOptions());
  ASSERT_EQ(blobs.size(), 1u);
  EXPECT_EQ(blobs[0].points, 20u);
}

/// A straight road along x, 4 m wide, a point every 0.4 m.
LabelledCloud roadAlongX(float from, float to, std::uint32_t label = kRoad) {
  LabelledCloud cloud;
  for (int i = 0; from + 0.4f * static_cast<float>(i) < to; ++i) {
    for (int j = 0; j < 10; ++j) {
      const float x = from + 0.4f * static_cast<float>(i), y = 0.4f * static_cast<float>(j);
      cloud.points.push_back(Point(x, y, 0, label));
    }
  }
  return cloud;
}

TEST(Blobs, OfSurfacesNeverChainThroughTheTown) {
  const std::vector<Blob> blobs = extractBlobs(roadAlongX(0.1f, 1000), townLabels(), keepingAll());
  EXPECT_EQ(blobs.size(), 50u);
  std::uint32_t points = 0;
  for (const Blob& blob : blobs) {
    EXPECT_LE((blob.max - blob.min).maxCoeff(), BlobOptions().max_surface_m);
    points += blob.points;
  }
  EXPECT_EQ(points, 25000u) << "nothing is lost";
}

TEST(Blobs, OfSmallSurfacesAndOfLongObjectsStayWhole) {
  EXPECT_EQ(extractBlobs(roadAlongX(11, 30), townLabels(), keepingAll()).size(), 1u)
      << "shorter than a square, though across two";
  EXPECT_EQ(extractBlobs(roadAlongX(0, 100, kBench), townLabels(), keepingAll()).size(), 1u);
}

TEST(Blobs, AreCutInTheFrameWhateverTheOrigin) {
  LabelledCloud shifted = roadAlongX(0.1f, 100);
  shifted.origin = {-7, 0, 0};
  for (Point& p : shifted.points) p.x += 7;
  const auto a = extractBlobs(roadAlongX(0.1f, 100), townLabels(), keepingAll()),
             b = extractBlobs(shifted, townLabels(), keepingAll());
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i)
    EXPECT_LT((a[i].position - b[i].position).norm(), 1e-4);
}

TEST(Blobs, ThatAreCutDropPiecesBelowTheLimitOfPoints) {
  BlobOptions options = keepingAll();
  options.min_points = 60;
  std::vector<int> blob_of_point;
  const LabelledCloud cloud = roadAlongX(18.1f, 60);  // 5 columns of 10 points before the first cut
  const auto blobs = extractBlobs(cloud, townLabels(), options, &blob_of_point);
  EXPECT_EQ(blobs.size(), 2u);
  EXPECT_EQ(std::count(blob_of_point.begin(), blob_of_point.end(), -1), 50);
}

TEST(Blobs, OfSurfacesAreAsLargeAsTheyGetIfTold) {
  BlobOptions options = keepingAll();
  options.max_surface_m = 0;
  EXPECT_EQ(extractBlobs(roadAlongX(0, 1000), townLabels(), options).size(), 1u);
}

TEST(Blobs, AreEquivariantToMotion) {
  Random random(1);
  const std::vector<Eigen::Vector3f> points = clumpedPoints(2000, 30, random);
  const Eigen::Isometry3d T = randomPose(random);
  std::vector<Eigen::Vector3f> turned;
  for (const Eigen::Vector3f& p : points) {
    turned.push_back((T.linear() * p.cast<double>()).cast<float>());
  }
  const auto still = extractBlobs(cloudOf(points, kBench), townLabels(), keepingAll());
  const auto moved =
      extractBlobs(cloudOf(turned, kBench, T.translation()), townLabels(), keepingAll());
  ASSERT_EQ(moved.size(), still.size());
  for (std::size_t i = 0; i < still.size(); ++i) {
    EXPECT_LT((moved[i].position - T * still[i].position).norm(), 1e-4);
    const Eigen::Matrix3d turned_covariance =
        T.linear() * still[i].covariance * T.linear().transpose();
    EXPECT_LT((moved[i].covariance - turned_covariance).norm(),
              1e-3 * (1 + turned_covariance.norm()));
    EXPECT_EQ(moved[i].points, still[i].points);
  }
}

TEST(Blobs, OfEmptyUnlabelledAndAllNaNCloudsAreNone) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::vector<int> blob_of_point{1, 2, 3};
  EXPECT_TRUE(extractBlobs(LabelledCloud(), townLabels(), keepingAll(), &blob_of_point).empty());
  EXPECT_TRUE(blob_of_point.empty());
  EXPECT_TRUE(extractBlobs(box(kVoid, {0, 0, 0}, {3, 3, 3}), townLabels(), keepingAll()).empty());
  const LabelledCloud cloud = cloudOf({{nan, 0, 0}, {0, nan, 0}}, kCar);
  EXPECT_TRUE(extractBlobs(cloud, townLabels(), keepingAll(), &blob_of_point).empty());
  EXPECT_EQ(blob_of_point, (std::vector<int>{-1, -1}));
}

TEST(Blobs, OfOnePointAndOfALineAreValid) {
  const auto single = extractBlobs(cloudOf({{1, 2, 3}}, kCar), townLabels(), keepingAll());
  ASSERT_EQ(single.size(), 1u);
  EXPECT_EQ(single[0].position, Eigen::Vector3d(1, 2, 3));
  EXPECT_TRUE(single[0].covariance.isZero());
  const auto line = extractBlobs(box(kPole, {0, 0, 0}, {1, 1, 30}), townLabels(), keepingAll());
  ASSERT_EQ(line.size(), 1u);
  EXPECT_NEAR(line[0].covariance.trace(), line[0].covariance(2, 2), 1e-9);
}

using VoxelKey = std::tuple<long, long, long, std::uint32_t, std::uint32_t>;

TEST(ThinByVoxel, GivesTheCentroidOfEachVoxelClassAndInstance) {
  Random random(2);
  LabelledCloud cloud = cloudOf(clumpedPoints(5000, 3, random), kCar, Eigen::Vector3d(100, -7, 3));
  for (Point& p : cloud.points) p.label = random.below(2) ? kCar : kRoad;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    cloud.points[i].instance = random.below(3);
    cloud.points[i].sigma = static_cast<float>(random.uniform(0.1, 5));
  }
  struct Sum {
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    double sigma = 0;
    std::uint32_t count = 0;
  };
  std::map<VoxelKey, Sum> expected;
  const auto cell = [](double c) { return static_cast<long>(std::floor(c / 0.25)); };
  const auto key = [&](const LabelledCloud& c, std::size_t i) {
    const Eigen::Vector3d p = c.position(i);
    return VoxelKey(cell(p.x()), cell(p.y()), cell(p.z()), c.points[i].label, c.points[i].instance);
  };
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    Sum& sum = expected[key(cloud, i)];
    sum.position += cloud.position(i);
    sum.sigma += cloud.points[i].sigma;
    ++sum.count;
  }

  std::vector<std::uint32_t> counts;
  const LabelledCloud thin = thinByVoxel(cloud, 0.25, &counts);
  ASSERT_EQ(thin.size(), expected.size());
  ASSERT_EQ(counts.size(), expected.size());
  for (std::size_t i = 0; i < thin.size(); ++i) {
    ASSERT_TRUE(expected.count(key(thin, i)));
    const Sum& sum = expected[key(thin, i)];
    EXPECT_EQ(counts[i], sum.count);
    EXPECT_LT((thin.position(i) - sum.position / sum.count).norm(), 1e-4);
    EXPECT_NEAR(thin.points[i].sigma, sum.sigma / sum.count, 1e-4);
  }
}

TEST(ThinByVoxel, KeepsTheOrderOfFirstAppearance) {
  const LabelledCloud cloud =
      cloudOf({{5, 0, 0}, {1, 0, 0}, {5.01f, 0, 0}, {3, 0, 0}, {1.01f, 0, 0}}, kCar);
  const LabelledCloud thin = thinByVoxel(cloud, 0.5);
  ASSERT_EQ(thin.size(), 3u);
  EXPECT_FLOAT_EQ(thin.points[0].x, 5.005f);
  EXPECT_FLOAT_EQ(thin.points[1].x, 1.005f);
  EXPECT_FLOAT_EQ(thin.points[2].x, 3);
}

TEST(ThinByVoxel, HasVoxelsThatDoNotMoveWithTheOrigin) {
  Random random(3);
  const auto points = clumpedPoints(3000, 5, random);
  std::vector<Eigen::Vector3f> shifted;
  for (const Eigen::Vector3f& p : points) shifted.push_back(p + Eigen::Vector3f(4, -2, 1));
  const LabelledCloud a = thinByVoxel(cloudOf(points, kCar), 0.3);
  const LabelledCloud b = thinByVoxel(cloudOf(shifted, kCar, {-4, 2, -1}), 0.3);
  ASSERT_NEAR(static_cast<double>(a.size()), static_cast<double>(b.size()), 2);
}

TEST(ThinByVoxel, LeavesOutWhatIsNotFiniteOrFurtherThanAnyCell) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const LabelledCloud thin =
      thinByVoxel(cloudOf({{nan, 0, 0}, {0, 1e30f, 0}, {1, 1, 1}}, kCar), 0.1);
  ASSERT_EQ(thin.size(), 1u);
  EXPECT_EQ(thin.points[0].x, 1);
}

TEST(ThinByVoxel, OfSizeZeroOrOfNothingChangesNothing) {
  const LabelledCloud cloud = cloudOf({{1, 1, 1}, {1, 1, 1}}, kCar);
  std::vector<std::uint32_t> counts;
  EXPECT_EQ(thinByVoxel(cloud, 0, &counts).size(), 2u);
  EXPECT_EQ(counts, (std::vector<std::uint32_t>{1, 1}));
  EXPECT_TRUE(thinByVoxel(LabelledCloud(), 0.1, &counts).empty());
  EXPECT_TRUE(counts.empty());
}

}  // namespace
}  // namespace xview
