// SPDX-License-Identifier: BSD-3-Clause
#include "place/lift.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "scenes.h"

namespace xview {

namespace {

using namespace test;

/// Every column of every point.
std::string textOf(const LabelledCloud& cloud) {
  std::string text;
  const auto append = [&](const auto& value) {
    text.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  for (const Point& p : cloud.points) {
    append(p.x), append(p.y), append(p.z), append(p.label);
    append(p.instance), append(p.sigma), append(p.view);
  }
  for (int k = 0; k < 3; ++k) append(cloud.origin[k]);
  return text;
}

LabelledCloud withoutSurfaces(const LabelledCloud& cloud, const LabelSet& set) {
  LabelledCloud rest;
  rest.origin = cloud.origin;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (set.role(cloud.points[i].label) == Role::surface) continue;
    rest.points.push_back(cloud.points[i]);
  }
  return rest;
}

constexpr double kVoxel_m = 0.4;

void expectTheSameInOneGo(const Frame& frame) {
  LiftCounts counts, counts_in_one_go;
  std::vector<std::uint32_t> points_per_voxel;
  const LabelledCloud all = lift(frame, townLabels(), {}, &counts);
  const LabelledCloud thin = thinByVoxel(all, kVoxel_m, &points_per_voxel);
  ASSERT_FALSE(thin.empty());
  ASSERT_LT(thin.size(), all.size());
  const ThinFrame found =
      liftThin(frame, townLabels(), {}, kVoxel_m, WholeClasses::all, &counts_in_one_go);
  EXPECT_EQ(textOf(found.thin), textOf(thin));
  EXPECT_EQ(found.points_per_voxel, points_per_voxel);
  EXPECT_EQ(textOf(found.whole), textOf(all));
  EXPECT_EQ(counts_in_one_go.lifted, counts.lifted);
  EXPECT_EQ(counts_in_one_go.no_depth, counts.no_depth);
  EXPECT_EQ(counts_in_one_go.out_of_range, counts.out_of_range);
  EXPECT_EQ(counts_in_one_go.ignored_class, counts.ignored_class);
  const auto wholeOf = [&](WholeClasses classes) {
    return textOf(liftThin(frame, townLabels(), {}, kVoxel_m, classes).whole);
  };
  EXPECT_EQ(wholeOf(WholeClasses::no_surfaces), textOf(withoutSurfaces(all, townLabels())));
  LabelledCloud nothing;
  nothing.origin = all.origin;
  EXPECT_EQ(wholeOf(WholeClasses::none), textOf(nothing));
}

/// Patches of some classes at depths of 1 to 70 m with holes.
Frame patchwork(std::uint64_t seed) {
  Random random(seed);
  Frame frame = flatFrame(70, 50, kRoad, 5);
  for (int v = 0; v < 50; ++v) {
    for (int u = 0; u < 70; ++u) {
      const std::uint16_t classes[] = {kRoad, kCar, kBuilding, kVoid};
      frame.label.at(u, v) = classes[(u / 9 + v / 7) % 4];
      frame.depth.at(u, v) = static_cast<float>(1 + (u / 5 * v / 4) % 70 + random.uniform(0, 0.3));
      if (random.below(10) == 0) frame.depth.at(u, v) = 0;
    }
  }
  frame.depth.at(1, 1) = std::numeric_limits<float>::quiet_NaN();
  frame.T_odom_sensor = randomPose(random);
  return frame;
}

TEST(ThinFrame, IsTheThinnedCloudOfTheLiftedFrame) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    Frame frame = patchwork(seed);
    expectTheSameInOneGo(frame);
    frame.camera.depth_is_range = true;
    expectTheSameInOneGo(frame);
    frame.instance = LabelImage(70, 50);
    for (std::size_t i = 0; i < frame.instance.pixels.size(); ++i)
      frame.instance.pixels[i] = static_cast<std::uint16_t>(i / 40);
    expectTheSameInOneGo(frame);
  }
}

TEST(ThinFrame, OfAScanAndOfASavedCloudIsTheThinnedCloud) {
  Random random(4);
  Frame frame;
  frame.sensor = Sensor::lidar;
  for (int i = 0; i < 3000; ++i) {
    const auto at = [&] { return static_cast<float>(std::floor(random.uniform(-3, 3)) * 0.9); };
    frame.cloud.points.push_back({at(), at(), at(), random.below(2) ? kRoad : kCar});
  }
  frame.cloud.points[7].x = std::numeric_limits<float>::infinity();
  frame.T_odom_sensor = randomPose(random);
  expectTheSameInOneGo(frame);
  frame.sensor = Sensor::cloud;
  expectTheSameInOneGo(frame);
  for (Point& p : frame.cloud.points) p.instance = 5;
  expectTheSameInOneGo(frame);
}

TEST(ThinFrame, IsAerialIfTheNearestTenthOfACameraIsFarAway) {
  const auto isAerial = [](const Frame& frame) {
    return liftThin(frame, townLabels(), {}, kVoxel_m, WholeClasses::none).is_aerial;
  };
  Frame frame = flatFrame(20, 20, kRoad, 45);
  EXPECT_TRUE(isAerial(frame));
  for (int i = 0; i < 39; ++i) frame.depth.pixels[static_cast<std::size_t>(i)] = 5;
  EXPECT_TRUE(isAerial(frame));
  frame.depth.pixels[39] = 5;
  EXPECT_FALSE(isAerial(frame));
  EXPECT_FALSE(isAerial(flatFrame(20, 20, kVoid, 45)));
}

TEST(ThinFrame, OfNothingIsEmpty) {
  const ThinFrame none =
      liftThin(flatFrame(4, 4, kRoad, 0), townLabels(), {}, kVoxel_m, WholeClasses::all);
  EXPECT_TRUE(none.thin.empty());
  EXPECT_TRUE(none.whole.empty());
  EXPECT_TRUE(none.points_per_voxel.empty());
  EXPECT_FALSE(none.is_aerial);
}

}  // namespace
}  // namespace xview
