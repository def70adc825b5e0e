// SPDX-License-Identifier: BSD-3-Clause
#include "place/storeys.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"
#include "place/bev_grid.h"

namespace xview {
namespace {

constexpr double kStoreyHeight_m = 3;  // from floor to floor
constexpr std::uint32_t kFloorClass = 1, kWallClass = 2;

LabelSet labelsOfRooms() {
  LabelSet labels("rooms");
  ClassInfo floor{kFloorClass, "floor", {1, 1, 1}, Role::surface};
  floor.kind = Kind::terrain;
  ClassInfo wall{kWallClass, "wall", {2, 2, 2}, Role::surface};
  wall.kind = Kind::building;
  labels.add(floor);
  labels.add(wall);
  return labels;
}

/// A walk to and fro on each floor, and what there is: floors, walls beside the way, ceilings.
/// Lengths are canonical ones of rooms.
struct Building {
  explicit Building(int floors, double height_m = kStoreyHeight_m, double sensor_m = 1.2) {
    for (int floor = 0; floor < floors; ++floor) addFloor(floor * height_m, sensor_m);
  }

  void addFloor(double z_m, double sensor_m) {
    for (double x = 0; x < 20; x += 0.5) addPose(x, z_m + sensor_m);
    for (double x = 0; x < 20; x += 0.05) {
      for (double y = -2; y <= 2; y += 0.1) addPoint(x, y, z_m, kFloorClass);
      for (double y = -2; y <= 2; y += 0.1) addPoint(x, y, z_m + 2.7, kWallClass);  // a ceiling
      for (double z = 0.1; z < 2.7; z += 0.1) addPoint(x, 2, z_m + z, kWallClass);
    }
  }
  void addPose(double x, double z) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translation() = Eigen::Vector3d(x, 0, z) / kRoomScale;
    place.poses.push_back(T);
  }
  void addPoint(double x, double y, double z, std::uint32_t label) {
    const Eigen::Vector3f p = (Eigen::Vector3d(x, y, z) / kRoomScale).cast<float>();
    place.cloud.points.push_back(Point(p.x(), p.y(), p.z(), label));
  }
  std::vector<Storey> storeys(double size = kRoomScale) const {
    StoreyFinder finder(place.poses, Eigen::Quaterniond::Identity(), size);
    finder.add(place.cloud, labelsOfRooms());
    return finder.storeys();
  }

  Place place;
};

TEST(Storeys, BeginBetweenTheCeilingBelowAndTheirFloor) {
  const std::vector<Storey> storeys = Building(4).storeys();
  ASSERT_EQ(storeys.size(), 4U);
  EXPECT_TRUE(storeys.front().holds(-1e9));
  EXPECT_TRUE(storeys.back().holds(1e9));
  for (std::size_t i = 1; i < storeys.size(); ++i) {
    EXPECT_EQ(storeys[i - 1].top, storeys[i].bottom);
    const double above_floor_m =
        storeys[i].bottom * kRoomScale - static_cast<double>(i) * kStoreyHeight_m;
    EXPECT_LT(above_floor_m, -0.01);
    EXPECT_GT(above_floor_m, -0.3);
  }
}

TEST(Storeys, AreNoneWhereNobodyWalkedAbove) {
  EXPECT_TRUE(Building(1).storeys().empty());
  Building wings(1);
  Building upper(1);
  for (Eigen::Isometry3d T : upper.place.poses) {  // a wing beside, half a storey up
    T.translation() += Eigen::Vector3d(40, 0, kStoreyHeight_m) / kRoomScale;
    wings.place.poses.push_back(T);
  }
  EXPECT_TRUE(wings.storeys().empty());
}

TEST(Storeys, OfACloudAreWhereFloorsLieAboveOneAnother) {
  Building building(3);
  building.place.poses.clear();
  const std::vector<Storey> storeys = building.storeys();
  ASSERT_EQ(storeys.size(), 3U);
  for (std::size_t i = 1; i < storeys.size(); ++i) {
    const double above_floor_m =
        storeys[i].bottom * kRoomScale - static_cast<double>(i) * kStoreyHeight_m;
    EXPECT_LT(above_floor_m, -0.01);
    EXPECT_GT(above_floor_m, -0.3);
  }
}

TEST(Storeys, OfACloudAreNoneWhereNothingLiesAboveAFloorThatOneCanStandOn) {
  Building hall(1);  // with tall narrow shelves, and a wing beside that is half a storey up
  hall.place.poses.clear();
  EXPECT_TRUE(hall.storeys().empty());
  for (double x = 0; x < 20; x += 0.05) {
    for (double y = 0.55; y <= 0.95; y += 0.1) hall.addPoint(x, y, 2.1, kWallClass);
    for (double z = 0.1; z < 2.1; z += 0.1) hall.addPoint(x, 0.75, z, kWallClass);
    for (double y = -2; y <= 2; y += 0.1) hall.addPoint(x + 30, y, 2, kFloorClass);
    for (double z = 2.1; z < 4; z += 0.1) hall.addPoint(x + 30, 2, z, kWallClass);
  }
  EXPECT_TRUE(hall.storeys().empty());
}

TEST(Storeys, OfACloudAreNoneOfRoofsBesideTrees) {
  Building yard(0);
  const auto isContainer = [](double x, double y) {
    return std::fmod(x, 20) < 12 && std::fmod(y, 5) < 2.5;
  };
  for (double x = 0; x < 60; x += 0.2) {
    for (double y = 0; y < 60; y += 0.2) {
      const bool is_tree = x > 50 && y > 40;
      yard.addPoint(x, y, isContainer(x, y) ? 2.6 : 0, kFloorClass);
      for (double z = 0.5; is_tree && z < 6; z += 0.2) yard.addPoint(x, y, z, kWallClass);
      const bool is_side = isContainer(x, y) && std::fmod(y, 5) < 0.15;
      for (double z = 0.2; is_side && z < 2.6; z += 0.2) yard.addPoint(x, y, z, kWallClass);
    }
  }
  EXPECT_TRUE(yard.storeys().empty());
}

TEST(Storeys, AreNoneOfATownWhoseOdometryDriftsUp) {
  EXPECT_TRUE(Building(3).storeys(kTownScale).empty());
}

TEST(Storeys, NeedAFloorOfTheirOwn) {
  Building flown_over(1);
  for (double x = 0; x < 20; x += 0.5) flown_over.addPose(x, 9);
  EXPECT_TRUE(flown_over.storeys().empty());
}

TEST(Storeys, TwoSensorsOfOneRobotAreOnOne) {
  Building building(2);
  for (int floor = 0; floor < 2; ++floor) {
    for (double x = 0; x < 20; x += 0.5) building.addPose(x, floor * kStoreyHeight_m + 0.3);
  }
  EXPECT_EQ(building.storeys().size(), 2U);
}

TEST(Storeys, KeepTheirFloorsWhereThoseOfOthersWouldBeContradicted) {
  Building building(3);
  building.place.labels = labelsOfRooms();
  building.place.size = kRoomScale;
  const std::vector<StoreyOfPlace> storeys = storeysOf(building.place);
  ASSERT_EQ(storeys.size(), 3U);
  const std::size_t before = building.place.cloud.size();
  dropContradicted(storeys, building.place);
  EXPECT_GT(building.place.cloud.size(), before * 9 / 10);
  for (const StoreyOfPlace& storey : storeys)
    EXPECT_GT(storey.view[BevChannel::terrain].size(), storeys[0].view.known.size() / 2);
}

/// Nine of ten say wall, one something else, each somewhere else.
TEST(ViewsOfThinnedClouds, HaveTheClassesThatPrevail) {
  Random random(1, 1);
  LabelledCloud cloud;
  for (int i = 0; i < 20000; ++i) {
    const auto x = static_cast<float>(random.uniform(0, 40)),
               z = static_cast<float>(random.uniform(0, 6));
    cloud.points.push_back(Point(x, 10, z, random.uniform() < 0.9 ? kWallClass : kFloorClass));
    cloud.points.push_back(Point(x, static_cast<float>(random.uniform(0, 9)), 0, kFloorClass));
  }
  const BevGrid view = viewOfThinned(cloud, labelsOfRooms(), Eigen::Quaterniond::Identity());
  EXPECT_GT(view[BevChannel::building].size(), 70U);
  for (const GroundCell& cell : view.known) EXPECT_LT(std::abs(cell.z + view.origin_z), 0.5);
}

}  // namespace
}  // namespace xview
