// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/cloud_density.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "pipeline/simulated_drive.h"
#include "xview/mapper.h"

namespace xview {
namespace {

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
  std::vector<float> trust() const { return trustByDensity(cloud, points, kVoxel_m); }
};

TEST(CloudDensity, KeepsAllOfSharpSurfaces) {
  Voxels v;
  v.addSlab(0, 1, 1, 40);
  v.addSlab(30, 1, 1, 2);
  v.addSlab(60, 1, 5, 1);
  for (const float trust : v.trust()) EXPECT_EQ(trust, 1);
}

TEST(CloudDensity, TakesFromThickSurfacesByTheSquareOfTheirDensity) {
  Voxels v;
  v.addSlab(0, 3, 1, 40);
  const std::size_t dense = v.points.size();
  v.addSlab(30, 3, 1, 10);
  const std::vector<float> trust = v.trust();
  for (std::size_t i = 0; i < trust.size(); ++i) EXPECT_FLOAT_EQ(trust[i], i < dense ? 1 : 1. / 16);
}

TEST(CloudDensity, IsSeenInThinnedCloudsToo) {
  Voxels v;
  v.addSlab(0, 3, 1, 1);
  const std::size_t dense = v.points.size();
  v.addSlab(30, 3, 9, 1);
  const std::vector<float> trust = v.trust();
  for (std::size_t i = 0; i < trust.size(); ++i) {
    if (i < dense) {
      EXPECT_EQ(trust[i], 1);
    } else {
      EXPECT_LT(trust[i], 0.1);
    }
  }
}

TEST(CloudDensity, IsNotJudgedByWhereTheSensorStood) {
  Voxels stood, passed;
  for (Voxels* v : {&stood, &passed}) {
    v->addSlab(0, 3, 1, v == &stood ? 100000 : 100);
    v->addSlab(30, 3, 1, 50);
  }
  EXPECT_EQ(stood.trust(), passed.trust());
}

TEST(CloudDensity, DoesNotDependOnTheOrderOfTheVoxels) {
  Voxels v;
  v.addSlab(0, 3, 2, 40);
  v.addSlab(30, 3, 5, 3);
  std::vector<float> forward = v.trust();
  std::reverse(v.cloud.points.begin(), v.cloud.points.end());
  std::reverse(v.points.begin(), v.points.end());
  std::reverse(forward.begin(), forward.end());
  EXPECT_EQ(v.trust(), forward);
}

TEST(CloudDensity, OfNothingIsNothing) { EXPECT_TRUE(Voxels().trust().empty()); }

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
  const FrameDigest digest = digestFrame(frame, labels, Options());
  ASSERT_GT(digest.votes.size(), 0U);
  for (std::size_t i = 0; i < digest.votes.size(); ++i) {
    const bool far = digest.cloud.points[i].x > 20;
    if (digest.cloud.points[i].label == pole) {
      EXPECT_FLOAT_EQ(digest.votes[i], far ? 0.5 : 2);
    } else if (far) {
      EXPECT_LT(digest.votes[i], 0.05);
    }
  }
}

}  // namespace
}  // namespace xview
