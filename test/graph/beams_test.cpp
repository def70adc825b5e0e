// SPDX-License-Identifier: BSD-3-Clause
#include "xview/graph/blobs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "scenes.h"
#include "xview/graph/blobs.h"

namespace xview {

using namespace graph;

namespace {

using namespace test;

constexpr double kDegree = M_PI / 180;

Eigen::Vector3f onRay(double azimuth, double elevation, double range_m) {
  return (range_m * Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth),
                                    std::cos(elevation) * std::sin(azimuth), std::sin(elevation)))
      .cast<float>();
}

/// A scan 1.8 m above the ground of a square of houses, every tenth return lost.
LabelledCloud scanOfASquare(int beams, double lowest_deg, double highest_deg, int per_turn,
                            Random& random) {
  LabelledCloud cloud;
  for (int beam = 0; beam < beams; ++beam) {
    const double elevation =
        kDegree * (lowest_deg + (highest_deg - lowest_deg) * beam / std::max(1, beams - 1));
    for (int i = 0; i < per_turn; ++i) {
      const double azimuth = 2 * M_PI * i / per_turn - M_PI;
      const double to_house =
          12 / std::max(std::abs(std::cos(azimuth)), std::abs(std::sin(azimuth)));
      const double to_ground = elevation < 0 ? 1.8 / -std::tan(elevation) : 1e9;
      const double range = std::min(to_house, to_ground) / std::cos(elevation);
      if (random.uniform() < 0.1) continue;
      const Eigen::Vector3f p = onRay(azimuth, elevation, range + 0.02 * random.normal());
      cloud.points.push_back(Point(p.x(), p.y(), p.z(), kBuilding));
    }
  }
  return cloud;
}

TEST(BeamSpacing, IsThatOfTheScanner) {
  Random random(1);
  struct Scanner {
    int beams;
    double lowest, highest;
    int per_turn;
  };
  for (const Scanner& s :
       {Scanner{64, -24.8, 2, 2000}, Scanner{64, -24.8, 2, 1024}, Scanner{32, -30.7, 10.7, 1080},
        Scanner{16, -15, 15, 1800}, Scanner{40, -16, 7, 1800}}) {
    const LabelledCloud scan = scanOfASquare(s.beams, s.lowest, s.highest, s.per_turn, random);
    const BeamSpacing spacing = measureBeamSpacing(scan);
    ASSERT_TRUE(spacing.isKnown()) << s.beams;
    const double between_beams = (s.highest - s.lowest) / (s.beams - 1);
    EXPECT_NEAR(spacing.elevation_rad / kDegree, between_beams, 0.1 * between_beams) << s.beams;
    EXPECT_NEAR(spacing.azimuth_rad / kDegree, 360.0 / s.per_turn, 0.25 * 360 / s.per_turn)
        << s.beams;
  }
}

TEST(BeamSpacing, DoesNotDependOnTheOrderOfThePoints) {
  Random random(2);
  LabelledCloud scan = scanOfASquare(32, -30, 10, 1000, random);
  const BeamSpacing in_order = measureBeamSpacing(scan);
  std::mt19937 generator(3);
  std::shuffle(scan.points.points.begin(), scan.points.points.end(), generator);
  const BeamSpacing shuffled = measureBeamSpacing(scan);
  EXPECT_EQ(shuffled.elevation_rad, in_order.elevation_rad);
  EXPECT_EQ(shuffled.azimuth_rad, in_order.azimuth_rad);
}

/// The number of the beam of each point, from the top downwards.
std::vector<std::uint16_t> ringsOf(const LabelledCloud& scan, int beams, double lowest_deg,
                                   double highest_deg) {
  std::vector<std::uint16_t> rings;
  for (const Point& p : scan.points) {
    const double elevation = std::atan2(p.z, std::hypot(p.x, p.y)) / kDegree;
    const double beam = (elevation - lowest_deg) / (highest_deg - lowest_deg) * (beams - 1);
    rings.push_back(static_cast<std::uint16_t>(beams - 1 - std::lround(beam)));
  }
  return rings;
}

TEST(BeamSpacing, IsThatOfTheRingsIfTheCloudHasThem) {
  Random random(11);
  const LabelledCloud scan = scanOfASquare(64, -24.8, 2, 1800, random);
  const std::vector<std::uint16_t> rings = ringsOf(scan, 64, -24.8, 2);
  // A twelfth of the points, at random from where the scanner looks.
  LabelledCloud thin;
  std::vector<std::uint16_t> thin_rings;
  for (std::size_t i = 0; i < scan.size(); i += 12) {
    thin.points.push_back(scan.points[i]);
    thin_rings.push_back(rings[i]);
  }
  const double between_beams = 26.8 / 63;
  EXPECT_NEAR(measureBeamSpacing(scan, rings).elevation_rad / kDegree, between_beams,
              0.02 * between_beams);
  EXPECT_NEAR(measureBeamSpacing(scan, rings).azimuth_rad / kDegree, 0.2, 0.03);
  EXPECT_NEAR(measureBeamSpacing(thin, thin_rings).elevation_rad / kDegree, between_beams,
              0.02 * between_beams);
}

TEST(BeamSpacing, IgnoresRingsThatTellNothing) {
  Random random(12);
  LabelledCloud scan = scanOfASquare(32, -30, 10, 1000, random);
  const BeamSpacing without = measureBeamSpacing(scan);
  std::vector<std::uint16_t> rings(scan.size(), 0);
  EXPECT_EQ(measureBeamSpacing(scan, rings).elevation_rad, without.elevation_rad);
  for (std::size_t i = 0; i < scan.size(); ++i)
    rings[i] = static_cast<std::uint16_t>(random.below(32));
  EXPECT_EQ(measureBeamSpacing(scan, rings).elevation_rad, without.elevation_rad);
  rings.resize(3);
  EXPECT_EQ(measureBeamSpacing(scan, rings).elevation_rad, without.elevation_rad);
}

TEST(BeamSpacing, OfACloudFromManyPlacesIsUnknown) {
  Random random(4);
  LabelledCloud cloud;
  for (int i = 0; i < 100000; ++i) {
    cloud.points.push_back(Point(static_cast<float>(random.uniform(-50, 50)),
                                 static_cast<float>(random.uniform(-50, 50)),
                                 static_cast<float>(random.uniform(-2, 8)), kBuilding));
  }
  const BeamSpacing dense = measureBeamSpacing(cloud);
  EXPECT_TRUE(!dense.isKnown() || dense.elevation_rad < 0.2 * kDegree);
  cloud.points.resize(5000);
  EXPECT_FALSE(measureBeamSpacing(cloud).isKnown());
}

TEST(BeamSpacing, OfNearlyNothingIsUnknown) {
  EXPECT_FALSE(measureBeamSpacing({}).isKnown());
  LabelledCloud cloud = cloudOf({{10, 0, 0}, {10, 0, 1}, {0, 10, 1}}, kPole);
  EXPECT_FALSE(measureBeamSpacing(cloud).isKnown());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(measureBeamSpacing(cloudOf({{nan, nan, nan}, {10, nan, 0}}, kPole)).isKnown());
}

TEST(AlongBeams, NeighboursJoinExactlyAsAmongAllPairs) {
  Random random(5);
  const BeamSpacing beams{0.3 * kDegree, 1.3 * kDegree};
  constexpr float kDepth = 0.5f;
  for (int round = 0; round < 20; ++round) {
    std::vector<Eigen::Vector3f> points;
    for (int i = 0; i < 300; ++i) {
      // Half of them around the seam of the image.
      const double azimuth = (i % 2 ? M_PI : 0.5) + random.uniform(-3, 3) * kDegree;
      points.push_back(onRay(azimuth, random.uniform(-6, 6) * kDegree, random.uniform(45, 48)));
    }
    std::vector<int> expected(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) expected[i] = static_cast<int>(i);
    std::vector<int> found = expected;
    const auto areNext = [&](const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
      const double elevation = std::asin(static_cast<double>(a.z()) / a.norm()) -
                               std::asin(static_cast<double>(b.z()) / b.norm());
      const double azimuth = std::remainder(std::atan2(static_cast<double>(a.y()), a.x()) -
                                                std::atan2(static_cast<double>(b.y()), b.x()),
                                            2 * M_PI);
      return std::abs(elevation) <= 2.2 * beams.elevation_rad &&
             std::abs(azimuth) <= 2.2 * beams.azimuth_rad &&
             std::abs(a.norm() - b.norm()) <= kDepth;
    };
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t i = 0; i < points.size(); ++i) {
        for (std::size_t j = 0; j < points.size(); ++j) {
          if (expected[j] >= expected[i] || !areNext(points[i], points[j])) continue;
          expected[i] = expected[j];
          changed = true;
        }
      }
    }
    joinAlongBeams(points, beams, kDepth, found);
    EXPECT_EQ(found, expected) << round;
  }
}

TEST(AlongBeams, ThinThingsNeedFewerPointsFarAwayAndSparseScannersFewer) {
  const BeamSpacing dense{0.17 * kDegree, 0.42 * kDegree}, sparse{0.33 * kDegree, 1.33 * kDegree};
  EXPECT_EQ(pointsOfThinThing(5, dense, 20), 20);
  EXPECT_EQ(pointsOfThinThing(5, BeamSpacing(), 20), 20);
  int last = 20;
  for (double range = 5; range < 60; range += 5) {
    const int needed = pointsOfThinThing(range, dense, 20);
    EXPECT_LE(needed, last);
    EXPECT_GE(needed, pointsOfThinThing(range, sparse, 20));
    EXPECT_GE(needed, 4);
    last = needed;
  }
  EXPECT_EQ(last, 4);
  EXPECT_EQ(pointsOfThinThing(60, dense, 2), 2);
}

/// A post of 0.15 m and 3 m height as a scanner sees it, and what its blobs are.
struct SeenPost {
  LabelledCloud cloud;
  ScanView scan;
};

SeenPost seenPost(double range_m, double azimuth, const BeamSpacing& beams) {
  SeenPost post;
  post.scan.beams = beams;
  std::vector<Eigen::Vector3f> points;
  const double half_width = 0.075 / range_m;
  for (double e = -std::atan2(1.8, range_m); e < std::atan2(1.2, range_m);
       e += beams.elevation_rad) {
    for (double a = -half_width; a <= half_width; a += beams.azimuth_rad)
      points.push_back(onRay(azimuth + a, e, range_m / std::cos(e)));
  }
  post.cloud = cloudOf(points, kPole);
  return post;
}

TEST(BlobsOfAScan, APostIsOneBlobAtAnyRange) {
  const BeamSpacing sparse{0.33 * kDegree, 1.33 * kDegree};
  for (const double range : {15.0, 25.0, 35.0}) {
    const SeenPost post = seenPost(range, 2, sparse);
    const std::vector<Blob> blobs =
        extractBlobs(post.cloud, townLabels(), BlobOptions(), nullptr, post.scan);
    if (post.cloud.size() < 4) {
      EXPECT_TRUE(blobs.empty()) << range;
      continue;
    }
    ASSERT_EQ(blobs.size(), 1u) << range;
    EXPECT_EQ(blobs[0].points, post.cloud.size());
    EXPECT_TRUE(extractBlobs(post.cloud, townLabels(), BlobOptions()).empty()) << range;
  }
}

TEST(BlobsOfAScan, TwoPostsThreeMetresApartStayTwo) {
  const BeamSpacing beams{0.17 * kDegree, 0.42 * kDegree};
  SeenPost post = seenPost(40, 1, beams);
  const SeenPost other = seenPost(40, 1 + 3.0 / 40, beams), behind = seenPost(43, 1, beams);
  for (const LabelledCloud* more : {&other.cloud, &behind.cloud}) post.cloud.points += more->points;
  EXPECT_EQ(extractBlobs(post.cloud, townLabels(), BlobOptions(), nullptr, post.scan).size(), 3u);
}

TEST(BlobsOfAScan, AFragmentAboveAPostIsNoOtherPost) {
  const BeamSpacing beams{0.17 * kDegree, 0.42 * kDegree};
  SeenPost post = seenPost(30, 1, beams);
  const std::size_t whole = post.cloud.size();
  LabelledCloud cut = post.cloud;
  cut.points.points.clear();
  for (const Point& p : post.cloud.points) {
    if (p.z < -0.2 || p.z > 0.9) cut.points.push_back(p);  // a branch in front
  }
  ASSERT_LT(cut.size(), whole);
  EXPECT_EQ(extractBlobs(cut, townLabels(), BlobOptions(), nullptr, post.scan).size(), 1u);
}

TEST(BlobsOfAScan, OfAThingThatIsNotThinNeedAllTheirPoints) {
  SeenPost post = seenPost(60, 1, {0.17 * kDegree, 0.42 * kDegree});
  for (Point& p : post.cloud.points) p.label = kCar;
  ASSERT_LT(post.cloud.size(), 20u);
  EXPECT_TRUE(extractBlobs(post.cloud, townLabels(), BlobOptions(), nullptr, post.scan).empty());
}

TEST(BlobsOfAScan, AreThoseOfTheScanWhereverItStands) {
  Random random(6);
  const BeamSpacing beams{0.33 * kDegree, 1.33 * kDegree};
  SeenPost post = seenPost(20, 2.9, beams);
  post.cloud.points += seenPost(14, -3, beams).cloud.points;
  const auto here = extractBlobs(post.cloud, townLabels(), BlobOptions(), nullptr, post.scan);
  ASSERT_EQ(here.size(), 2u);
  const Eigen::Isometry3d T = randomPose(random);
  LabelledCloud moved = post.cloud;
  moved.origin = T.translation().array().round();
  for (std::size_t i = 0; i < moved.size(); ++i) {
    moved.points[i].getVector3fMap() = (T * post.cloud.position(i) - moved.origin).cast<float>();
  }
  const auto there =
      extractBlobs(moved, townLabels(), BlobOptions(), nullptr, ScanView{T, post.scan.beams});
  ASSERT_EQ(there.size(), here.size());
  for (std::size_t b = 0; b < here.size(); ++b) {
    EXPECT_EQ(there[b].points, here[b].points);
    EXPECT_LT((there[b].position - T * here[b].position).norm(), 1e-3);
  }
}

TEST(BlobsOfAScan, NearTheSensorAreThoseOfAnyCloud) {
  Random random(7);
  const ScanView scan{Eigen::Isometry3d::Identity(), {0.17 * kDegree, 0.42 * kDegree}};
  BlobOptions options;
  options.tolerance_m = 0.2;
  options.min_points = 3;
  const LabelledCloud cloud = cloudOf(clumpedPoints(2000, 6, random), kPole);
  std::vector<int> plain, of_scan;
  extractBlobs(cloud, townLabels(), options, &plain);
  extractBlobs(cloud, townLabels(), options, &of_scan, scan);
  EXPECT_EQ(of_scan, plain);
}

TEST(BlobsOfAScan, SurfacesAreCutToTheirLargestSize) {
  Random random(8);
  const LabelledCloud street = scanOfASquare(64, -24.8, 2, 2000, random);
  const ScanView scan{Eigen::Isometry3d::Identity(), measureBeamSpacing(street)};
  BlobOptions options;
  options.max_surface_m = 8;
  const auto blobs = extractBlobs(street, townLabels(), options, nullptr, scan);
  EXPECT_GT(blobs.size(), 4u);
  for (const Blob& blob : blobs) EXPECT_LE((blob.max - blob.min).head<2>().maxCoeff(), 8.01);
}

}  // namespace
}  // namespace xview
