// SPDX-License-Identifier: BSD-3-Clause
#include "place/point_quality.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "localizer/simulated_drive.h"
#include "xview/place_builder.h"

namespace xview {
namespace {

/// Points 10, 20 and 30 m from the sensor, known to `inverse_depth_sigma` times the square of that.
PreprocessedFrame frameOfThree(double inverse_depth_sigma) {
  PreprocessedFrame frame;
  frame.cloud.origin = {100, 0, 0};
  frame.T_odom_sensor.translation() = frame.cloud.origin;
  for (const float range : {10.f, 20.f, 30.f}) {
    frame.cloud.points.push_back(Point(range, 0, 0, 7));
    frame.cloud.points.back().sigma = static_cast<float>(inverse_depth_sigma * range * range);
  }
  return frame;
}

TEST(KnownPoints, AreThoseOfASmallError) {
  LabelledCloud cloud;
  EXPECT_EQ(appendKnownPoints(frameOfThree(1e-3).cloud, 0.5, kNoView, cloud), 2u);
  EXPECT_FLOAT_EQ(cloud.points[0].sigma, 0.1f);
  EXPECT_FLOAT_EQ(cloud.points[1].sigma, 0.4f) << "that of 0.9 m is left out";
}

TEST(KnownPoints, RangeIsThatFromTheSensor) {
  PreprocessedFrame frame = frameOfThree(0);
  EXPECT_FLOAT_EQ(rangeOf(frame, 1), 20);
  frame.sensor = Sensor::cloud;
  EXPECT_EQ(rangeOf(frame, 1), 0) << "a cloud does not tell";
}

TEST(KnownPoints, KeepTheirPlacesAndClasses) {
  LabelledCloud cloud;
  cloud.origin = {90, 5, 0};
  EXPECT_EQ(appendKnownPoints(frameOfThree(0).cloud, 0.5, kNoView, cloud), 3u);
  EXPECT_EQ(appendKnownPoints(frameOfThree(0).cloud, 0.5, kNoView, cloud), 3u);
  ASSERT_EQ(cloud.size(), 6u);
  EXPECT_EQ(cloud.position(4), Eigen::Vector3d(120, 0, 0));
  EXPECT_EQ(cloud.points[4].label, 7u);
}

TEST(KnownPoints, AreNotThoseWhoseErrorIsNoNumber) {
  LabelledCloud cloud;
  EXPECT_EQ(appendKnownPoints(frameOfThree(std::numeric_limits<double>::quiet_NaN()).cloud, 0.5,
                              kNoView, cloud),
            0u);
}

/// Points of a query whose frame has so many with these errors.
std::size_t pointsOfQuery(int well_known, int just_known) {
  PreprocessedFrame frame;
  for (int i = 0; i < well_known + just_known; ++i) {
    frame.cloud.points.push_back(Point(static_cast<float>(i), 20, 0, 7));
    frame.cloud.points.back().sigma = i < well_known ? 0.1f : 0.45f;
  }
  frame.weights.assign(frame.cloud.size(), 1);
  frame.resolves_thin.assign(frame.cloud.size(), true);
  return makeQuery(&frame, &frame + 1, genericLabelSet({7}), Options()).cloud.size();
}

/// From the air all ground is as far, and what seems known well was measured too short.
TEST(KnownPoints, AreNoneWhereTheyAreTheEdgeOfWhatIsKnownBadly) {
  EXPECT_EQ(pointsOfQuery(300, 100), 400u);
  EXPECT_EQ(pointsOfQuery(100, 300), 0u);
}

constexpr std::uint32_t kWall = 2, kFence = 5;

/// Points of one class on a small patch, all with the same depth error.
class Measurements {
 public:
  void add(int count, std::uint32_t label, float sigma_m, float x = 0.1f) {
    for (int i = 0; i < count; ++i) {
      Point point;
      point.x = x + 0.01f * static_cast<float>(i);
      point.y = point.z = 0.1f;
      point.label = label;
      point.sigma = sigma_m;
      cloud_.points.push_back(point);
    }
  }
  /// How many of those with this error are kept.
  long kept(float sigma_m) const {
    const std::vector<bool> keep = bestMeasured(cloud_);
    long count = 0;
    for (std::size_t i = 0; i < keep.size(); ++i)
      count += keep[i] && cloud_.points[i].sigma == sigma_m;
    return count;
  }

 private:
  LabelledCloud cloud_;
};

TEST(BestMeasured, WhatWasSeenFromAfarGivesWayToWhatWasSeenFromNear) {
  Measurements cloud;
  cloud.add(20, kWall, 0.12f);
  cloud.add(30, kWall, 0.45f);
  EXPECT_EQ(cloud.kept(0.12f), 20);
  EXPECT_EQ(cloud.kept(0.45f), 0);
}

TEST(BestMeasured, WhatWasSeenOnlyFromAfarStays) {
  Measurements cloud;
  cloud.add(20, kWall, 0.12f);
  cloud.add(30, kWall, 0.45f, 10);
  EXPECT_EQ(cloud.kept(0.45f), 30);
}

TEST(BestMeasured, AnotherClassSaysNothing) {
  Measurements cloud;
  cloud.add(20, kWall, 0.12f);
  cloud.add(30, kFence, 0.45f);
  EXPECT_EQ(cloud.kept(0.45f), 30);
}

TEST(BestMeasured, AFewGoodPointsDoNotDecide) {
  Measurements cloud;
  cloud.add(3, kWall, 0.12f);
  cloud.add(30, kWall, 0.45f);
  EXPECT_EQ(cloud.kept(0.45f), 30);
}

TEST(BestMeasured, WhatIsKnownToADecimetreStaysAnywhere) {
  Measurements cloud;
  cloud.add(20, kWall, 0.01f);
  cloud.add(30, kWall, 0.09f);
  cloud.add(30, kWall, 0.3f);
  EXPECT_EQ(cloud.kept(0.09f), 30);
  EXPECT_EQ(cloud.kept(0.3f), 0);
}

TEST(BestMeasured, NothingGivesNothing) { EXPECT_TRUE(bestMeasured({}).empty()); }

/// Check fix for: patches of ground that a network labelled as things stood in the way of every
/// ray, and no point of a query agreed with them.
class Contradicted : public ::testing::Test {
 protected:
  static constexpr std::uint32_t kRoad = 1, kCrate = 2, kNobody = 3;
  static constexpr int kCells = 8;
  static constexpr float kGround_m = 5;  ///< above the origin of the grid

  /// Ground of 8 x 8 cells, the last column of which is only guessed, in a frame whose x axis
  /// points up.
  Contradicted() {
    labels_.add({kRoad, "road", {}, Role::surface, Kind::road});
    labels_.add({kCrate, "crate", {}, Role::object, Kind::other_object});
    bev_.origin_x = 128;
    bev_.origin_z = -2;
    bev_.alignment =
        Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ());
    for (int y = 0; y < kCells; ++y) {
      for (int x = 0; x < kCells; ++x) bev_.known.push_back({x, y, kGround_m, x + 1 < kCells});
    }
    cloud_.origin = bev_.alignment.conjugate() * Eigen::Vector3d(130, 1, 0);
  }

  /// Whether a point is kept that lies in cell (x, 2) at that height above the ground.
  bool keeps(int x, float height_m, std::uint32_t label) {
    const Eigen::Vector3d p((x + 0.5) * bev_.cell_m, 2.5 * bev_.cell_m, kGround_m + height_m);
    const Eigen::Vector3d origin(bev_.origin_x, bev_.origin_y, bev_.origin_z);
    const Eigen::Vector3f in_cloud =
        (bev_.alignment.conjugate() * (origin + p) - cloud_.origin).cast<float>();
    cloud_.points.assign(1, Point(in_cloud.x(), in_cloud.y(), in_cloud.z(), label));
    dropContradicted(bev_, labels_, cloud_);
    return cloud_.size() == 1;
  }

  LabelSet labels_{"test"};
  BevGrid bev_;
  LabelledCloud cloud_;
};

TEST_F(Contradicted, ThingsThatLieOnTheGroundAreDropped) {
  EXPECT_FALSE(keeps(3, 0.F, kCrate));
  EXPECT_FALSE(keeps(3, 0.15F, kCrate));
  EXPECT_FALSE(keeps(3, -0.15F, kCrate));
  EXPECT_TRUE(keeps(3, 0.3F, kCrate));
  EXPECT_TRUE(keeps(3, -0.5F, kCrate)) << "of a lower storey";
}

TEST_F(Contradicted, GroundFarAboveTheGroundIsDropped) {
  EXPECT_TRUE(keeps(3, 0.F, kRoad));
  EXPECT_TRUE(keeps(3, 0.4F, kRoad));
  EXPECT_FALSE(keeps(3, 1.F, kRoad));
}

TEST_F(Contradicted, NothingIsWhereNoGroundWasMeasured) {
  EXPECT_TRUE(keeps(kCells - 1, 0.F, kCrate)) << "there its height is guessed";
  EXPECT_TRUE(keeps(kCells, 0.F, kCrate));
  EXPECT_TRUE(keeps(-1, 3.F, kRoad));
  EXPECT_TRUE(keeps(3, 0.F, kNobody)) << "a class that nobody knows";
}

constexpr float kVoxel_m = 0.2F;

/// Voxels of a cloud and how many points each has.
struct Voxels {
  LabelledCloud cloud;
  std::vector<std::uint32_t> points;

  /// Every `step`-th voxel of a slab that is so many voxels thick, at x metres.
  void addSlab(float x, int thick, int step, std::uint32_t points_in_each) {
    int n = 0;
    for (int i = 0; i < thick; ++i) {
      for (int j = 0; j < 30; ++j) {
        for (int k = 0; k < 30; ++k) {
          if (n++ % step != 0) continue;
          const auto at = [](int v) { return kVoxel_m * (static_cast<float>(v) + 0.5F); };
          cloud.points.emplace_back(x + at(i), at(j), at(k), 1);
          points.push_back(points_in_each);
        }
      }
    }
  }
  std::vector<float> weights() const { return densityWeights(cloud, points, kVoxel_m); }
};

TEST(CloudDensity, KeepsAllOfSharpSurfaces) {
  Voxels v;
  v.addSlab(0, 1, 1, 40);
  v.addSlab(30, 1, 1, 2);
  v.addSlab(60, 1, 5, 1);
  for (const float weight : v.weights()) EXPECT_EQ(weight, 1);
}

TEST(CloudDensity, TakesFromThickSurfacesByTheSquareOfTheirDensity) {
  Voxels v;
  v.addSlab(0, 3, 1, 40);
  const std::size_t dense = v.points.size();
  v.addSlab(30, 3, 1, 10);
  const std::vector<float> weights = v.weights();
  for (std::size_t i = 0; i < weights.size(); ++i)
    EXPECT_FLOAT_EQ(weights[i], i < dense ? 1 : 1. / 16);
}

TEST(CloudDensity, IsSeenInThinnedCloudsToo) {
  Voxels v;
  v.addSlab(0, 3, 1, 1);
  const std::size_t dense = v.points.size();
  v.addSlab(30, 3, 9, 1);
  const std::vector<float> weights = v.weights();
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (i < dense) {
      EXPECT_EQ(weights[i], 1);
    } else {
      EXPECT_LT(weights[i], 0.1);
    }
  }
}

TEST(CloudDensity, IsNotJudgedByWhereTheSensorStood) {
  Voxels stood, passed;
  for (Voxels* v : {&stood, &passed}) {
    v->addSlab(0, 3, 1, v == &stood ? 100000 : 100);
    v->addSlab(30, 3, 1, 50);
  }
  EXPECT_EQ(stood.weights(), passed.weights());
}

TEST(CloudDensity, DoesNotDependOnTheOrderOfTheVoxels) {
  Voxels v;
  v.addSlab(0, 3, 2, 40);
  v.addSlab(30, 3, 5, 3);
  std::vector<float> forward = v.weights();
  std::reverse(v.cloud.points.begin(), v.cloud.points.end());
  std::reverse(v.points.begin(), v.points.end());
  std::reverse(forward.begin(), forward.end());
  EXPECT_EQ(v.weights(), forward);
}

TEST(CloudDensity, OfNothingIsNothing) { EXPECT_TRUE(Voxels().weights().empty()); }

TEST(CloudDensity, CountsSurfacesAndNotObjects) {
  const LabelSet& labels = test::simulatedDrive().labels;
  std::uint32_t road = 0, pole = 0;
  for (const auto& [id, info] : labels.classes()) {
    if (info.name == "road") road = id;
    if (info.name == "pole") pole = id;
  }
  Voxels v;
  v.addSlab(0, 3, 1, 4);
  v.addSlab(30, 3, 9, 1);
  Frame frame;
  frame.sensor = Sensor::cloud;
  for (std::size_t i = 0; i < v.points.size(); ++i) {
    for (std::uint32_t k = 0; k < v.points[i]; ++k) {
      frame.cloud.points.push_back(v.cloud.points[i]);
      frame.cloud.points.back().label = i % 50 == 0 ? pole : road;
    }
  }
  const PreprocessedFrame preprocessed = preprocessFrame(frame, labels, Options());
  ASSERT_GT(preprocessed.weights.size(), 0U);
  for (std::size_t i = 0; i < preprocessed.weights.size(); ++i) {
    const bool far = preprocessed.cloud.points[i].x > 20;
    if (preprocessed.cloud.points[i].label == pole) {
      EXPECT_FLOAT_EQ(preprocessed.weights[i], far ? 0.5 : 2);
    } else if (far) {
      EXPECT_LT(preprocessed.weights[i], 0.05);
    }
  }
}

/// What the cloud says of its points is asked, not their density.
TEST(CloudErrors, TakeVotes) {
  Frame frame;
  frame.sensor = Sensor::cloud;
  for (int i = 0; i < 400; ++i) {
    for (int k = 0; k < 4; ++k) frame.cloud.points.push_back(Point(i % 20, i / 20, 0, 3));
    for (int k = 0; k < 4; ++k) frame.cloud.points.rbegin()[k].sigma = i < 200 ? 0.01F : 0.9F;
  }
  const PreprocessedFrame preprocessed = preprocessFrame(frame, genericLabelSet({3}), {});
  ASSERT_EQ(preprocessed.weights.size(), 400U);
  for (std::size_t i = 0; i < preprocessed.weights.size(); ++i) {
    EXPECT_NEAR(preprocessed.cloud.points[i].sigma, i < 200 ? 0.01 : 0.9, 1e-6);
    EXPECT_NEAR(preprocessed.weights[i], i < 200 ? 2.0 : 0.5, 0.1);
  }
}

/// Where nearly every voxel holds one measurement, one is as good as it gets.
TEST(CloudDensity, OneMeasurementOfASparseScannerCountsInFull) {
  Frame frame;
  frame.sensor = Sensor::cloud;
  for (int i = 0; i < 400; ++i) {
    Point point;
    point.x = static_cast<float>(i % 20), point.y = static_cast<float>(i / 20);
    point.label = 3;
    frame.cloud.points.push_back(point);
  }
  const LabelSet labels = genericLabelSet({3});
  const auto weightsOf = [&](const Frame& seen) {
    return preprocessFrame(seen, labels, {}).weights;
  };
  for (const float weights : weightsOf(frame)) EXPECT_FLOAT_EQ(weights, 1);
  Frame dense = frame;
  for (int k = 0; k < 2; ++k) dense.cloud.points += frame.cloud.points;
  for (const float weights : weightsOf(dense)) EXPECT_FLOAT_EQ(weights, 1.5);
}

}  // namespace
}  // namespace xview
