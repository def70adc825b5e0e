// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <pcl/segmentation/extract_clusters.h>

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>

#include "place/blobs.h"
#include "place/lift.h"
#include "scenes.h"
#include "support/test_data.h"
#include "xview/io/recording.h"

namespace xview {

namespace {

using namespace test;
using Points = std::vector<Eigen::Vector3f>;

/// Clusters of pcl::EuclideanClusterExtraction, numbered by their first point.
std::vector<int> clustersOfPcl(const Points& points, float tolerance_m, int min_points) {
  pcl::PointCloud<pcl::PointXYZ>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZ>);
  for (const Eigen::Vector3f& p : points) cloud->push_back({p.x(), p.y(), p.z()});
  pcl::EuclideanClusterExtraction<pcl::PointXYZ> extraction;
  extraction.setInputCloud(cloud);
  extraction.setClusterTolerance(tolerance_m);
  extraction.setMinClusterSize(min_points);
  std::vector<pcl::PointIndices> clusters;
  extraction.extract(clusters);
  std::sort(clusters.begin(), clusters.end(), [](const auto& a, const auto& b) {
    return *std::min_element(a.indices.begin(), a.indices.end()) <
           *std::min_element(b.indices.begin(), b.indices.end());
  });
  std::vector<int> cluster_of_point(points.size(), -1);
  for (std::size_t c = 0; c < clusters.size(); ++c) {
    for (const auto i : clusters[c].indices) {
      cluster_of_point[static_cast<std::size_t>(i)] = static_cast<int>(c);
    }
  }
  return cluster_of_point;
}

void expectAsPcl(const Points& points, float tolerance_m, int min_points) {
  EXPECT_EQ(euclideanClusters(points, tolerance_m, min_points),
            clustersOfPcl(points, tolerance_m, min_points))
      << points.size() << " points, tolerance " << tolerance_m << ", at least " << min_points;
}

/// The points of each class of the thinned frame.
std::map<std::uint32_t, Points> pointsByClass(const Frame& frame, const LabelSet& set) {
  const LabelledCloud cloud = thinByVoxel(lift(frame, set, {}), 0.2);
  std::map<std::uint32_t, Points> result;
  for (const Point& p : cloud.points) result[p.label].push_back(p.getVector3fMap());
  return result;
}

TEST(EuclideanClusters, AreThoseOfPclOnRandomClouds) {
  Random random(1);
  for (const std::size_t count : {1u, 2u, 20u, 300u, 3000u}) {
    for (const float tolerance_m : {0.1f, 0.5f, 1.7f}) {
      expectAsPcl(clumpedPoints(count, 20, random), tolerance_m, 1);
      expectAsPcl(clumpedPoints(count, 5, random), tolerance_m, 20);
    }
  }
}

TEST(EuclideanClusters, AreThoseOfPclOnLatticesAtTheTolerance) {
  // All distances are equal to the tolerance up to rounding: the comparison must be that of FLANN,
  // bit by bit.
  for (const float spacing : {0.1f, 0.25f, 0.3f, 0.5f}) {
    Points lattice;
    for (int i = 0; i < 8 * 8 * 8; ++i) {
      lattice.emplace_back(static_cast<float>(i % 8) * spacing,
                           static_cast<float>(i / 8 % 8) * spacing,
                           static_cast<float>(i / 64) * spacing);
    }
    expectAsPcl(lattice, spacing, 1);
    expectAsPcl(lattice, spacing * 1.001f, 1);
    expectAsPcl(lattice, spacing * 0.999f, 1);
  }
}

TEST(EuclideanClusters, AreThoseOfPclOnAScan) {
  XVIEW_REQUIRE_DATA(data, "kitti00/map");
  const auto scans = io::openRecording(data);
  for (const auto& [label, points] : pointsByClass(scans->read(0), scans->labels())) {
    expectAsPcl(points, 0.5f, 20);
  }
}

TEST(EuclideanClusters, AreThoseOfPclOnRenderedFrames) {
  XVIEW_REQUIRE_DATA(data, "suburb_clean/forward");
  const auto frames = io::openRecording(data);
  for (const std::size_t index : {0u, 60u}) {
    for (const auto& [label, points] : pointsByClass(frames->read(index), frames->labels())) {
      expectAsPcl(points, 0.5f, 20);
      expectAsPcl(points, 0.3f, 1);
    }
  }
}

TEST(EuclideanClusters, OnALineFollowTheGaps) {
  Points line;
  for (const float x : {0.0f, 0.4f, 0.8f, 2.0f, 2.4f, 9.0f}) line.emplace_back(x, 0, 0);
  EXPECT_EQ(euclideanClusters(line, 0.5f, 1), (std::vector<int>{0, 0, 0, 1, 1, 2}));
  EXPECT_EQ(euclideanClusters(line, 0.5f, 2), (std::vector<int>{0, 0, 0, 1, 1, -1}));
  EXPECT_EQ(euclideanClusters(line, 0.5f, 4), std::vector<int>(6, -1));
}

TEST(EuclideanClusters, DoNotDependOnTheOrderOfThePoints) {
  Random random(2);
  const Points points = clumpedPoints(2000, 10, random);
  std::vector<std::uint32_t> order(points.size());
  std::iota(order.begin(), order.end(), 0u);
  for (std::size_t i = order.size(); i > 1; --i) {
    std::swap(order[i - 1], order[random.below(static_cast<std::uint32_t>(i))]);
  }
  Points shuffled;
  for (const std::uint32_t i : order) shuffled.push_back(points[i]);
  const std::vector<int> a = euclideanClusters(points, 0.5f, 5);
  const std::vector<int> b = euclideanClusters(shuffled, 0.5f, 5);
  std::map<int, int> number_in_b;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto [place, is_new] = number_in_b.try_emplace(a[order[i]], b[i]);
    ASSERT_EQ(place->second, b[i]);
  }
  EXPECT_EQ(*std::max_element(a.begin(), a.end()), *std::max_element(b.begin(), b.end()));
}

TEST(EuclideanClusters, OfEmptySingleAndAllNaN) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(euclideanClusters({}, 0.5f, 1).empty());
  EXPECT_EQ(euclideanClusters({{1, 2, 3}}, 0.5f, 1), std::vector<int>{0});
  EXPECT_EQ(euclideanClusters({{1, 2, 3}}, 0.5f, 2), std::vector<int>{-1});
  EXPECT_EQ(euclideanClusters(Points(5, {nan, 0, 0}), 0.5f, 1), std::vector<int>(5, -1));
}

TEST(EuclideanClusters, LeaveOutWhatIsNotFinite) {
  const float inf = std::numeric_limits<float>::infinity();
  EXPECT_EQ(euclideanClusters({{0, 0, 0}, {inf, 0, 0}, {0.1f, 0, 0}}, 0.5f, 1),
            (std::vector<int>{0, -1, 0}));
}

TEST(EuclideanClusters, OfEqualPointsAreOne) {
  EXPECT_EQ(euclideanClusters(Points(50, {7, 7, 7}), 0.5f, 50), std::vector<int>(50, 0));
}

TEST(EuclideanClusters, BearStrayPointsAtTheEndOfTheWorld) {
  Random random(3);
  Points points = clumpedPoints(1000, 5, random);
  const std::vector<int> without = euclideanClusters(points, 0.5f, 1);
  points.emplace_back(1e20f, 0, 0);
  points.emplace_back(0, -3e38f, 1e7f);
  std::vector<int> with = euclideanClusters(points, 0.5f, 1);
  const int clusters = *std::max_element(without.begin(), without.end()) + 1;
  EXPECT_EQ(with[1000], clusters);
  EXPECT_EQ(with[1001], clusters + 1);
  // Far from the smallest coordinate single precision blurs the cells no more than the points.
  with.resize(1000);
  EXPECT_EQ(with, without);
}

}  // namespace
}  // namespace xview
