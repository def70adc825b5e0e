// SPDX-License-Identifier: BSD-3-Clause
#include "sim/town.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <set>

#include "sim/building.h"
#include "support/test_data.h"

namespace xview {
namespace {

TownOptions smallTown(std::uint64_t seed) {
  TownOptions options;
  options.seed = seed;
  options.blocks_x = options.blocks_y = 2;
  return options;
}

bool sameBytes(const TriangleMesh& a, const TriangleMesh& b) {
  return a.vertices.size() == b.vertices.size() && a.triangles.size() == b.triangles.size() &&
         std::memcmp(a.vertices.data(), b.vertices.data(),
                     a.vertices.size() * sizeof(Eigen::Vector3f)) == 0 &&
         std::memcmp(a.triangles.data(), b.triangles.data(),
                     a.triangles.size() * sizeof(TriangleMesh::Triangle)) == 0;
}

std::set<std::uint16_t> classesOf(const TriangleMesh& mesh) {
  std::set<std::uint16_t> classes;
  for (const auto& triangle : mesh.triangles) classes.insert(triangle.tag.label);
  return classes;
}

TEST(Town, SameSeedSameBytesOtherSeedOtherTown) {
  const Town town = makeTown(smallTown(1));
  EXPECT_TRUE(sameBytes(town.mesh, makeTown(smallTown(1)).mesh));
  EXPECT_FALSE(sameBytes(town.mesh, makeTown(smallTown(2)).mesh));
}

TEST(Town, TrafficChangesWithTheDayOnly) {
  const Town town = makeTown(smallTown(1));
  EXPECT_TRUE(sameBytes(makeTraffic(town, 7), makeTraffic(town, 7)));
  EXPECT_FALSE(sameBytes(makeTraffic(town, 7), makeTraffic(town, 8)));
}

TEST(Town, HasEveryClassAndNoOther) {
  std::set<std::uint16_t> found;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    TownOptions options;
    options.seed = seed;
    const Town town = makeTown(options);
    for (const std::uint16_t c : classesOf(town.mesh)) found.insert(c);
    for (const std::uint16_t c : classesOf(makeTraffic(town, seed))) found.insert(c);
  }
  std::set<std::uint16_t> expected;
  const LabelSet labels = townLabels();
  for (const auto& [id, info] : labels.classes()) {
    if (info.role != Role::ignored) expected.insert(static_cast<std::uint16_t>(id));
  }
  EXPECT_EQ(found, expected);
}

TEST(Town, VerticesAreFiniteAndWithinTheTown) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Town town = makeTown(smallTown(seed));
    for (const Eigen::Vector3f& v : town.mesh.vertices) {
      ASSERT_TRUE(v.allFinite());
      ASSERT_LT(v.head<2>().cwiseAbs().maxCoeff(), 400);
      ASSERT_LT(std::abs(v.z()), 30);
    }
  }
}

TEST(Town, NoHouseStandsOnAStreet) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Town town = makeTown(smallTown(seed));
    for (const auto& triangle : town.mesh.triangles) {
      if (triangle.tag.label != town_class::kBuilding) continue;
      const Eigen::Vector3f v = town.mesh.vertices[triangle.corner[0]];
      ASSERT_GT(town.field.toRoad(v.head<2>().cast<double>()), 0.3) << "seed " << seed;
    }
  }
}

TEST(Town, GroundIsClosedAndCutAlongTheStreets) {
  TownOptions options = smallTown(4);
  options.relief_m = 3;
  Town town(options);
  addGround(town, 20);
  const auto scene = std::make_shared<const RayScene>(town.mesh);
  const Renderer renderer({scene});
  const Camera camera = pinholeCamera(64, 64, 1.0);
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
  T_world_camera.linear() << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  T_world_camera.translation() = Eigen::Vector3d(70, 70, 60);
  const Frame frame = renderer.renderCamera(camera, T_world_camera);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const double z = frame.depth.at(x, y);
      ASSERT_GT(z, 0);
      const Eigen::Vector3d p =
          T_world_camera *
          Eigen::Vector3d((x - camera.cx) / camera.fx * z, (y - camera.cy) / camera.fy * z, z);
      const double road = town.field.toRoad(p.head<2>()), walk = town.field.toSidewalk(p.head<2>());
      if (std::abs(road) < 0.15 || std::abs(walk) < 0.15) continue;  // edges are straightened
      const std::uint16_t expected = road < 0   ? town_class::kRoad
                                     : walk < 0 ? town_class::kSidewalk
                                                : town_class::kTerrain;
      EXPECT_EQ(frame.label.at(x, y), expected);
      EXPECT_NEAR(p.z(), town.onGround(p.head<2>()).z(), 1e-3);
    }
  }
}

TEST(Town, ExtremesOfTheOptionsAreFine) {
  TownOptions bare = smallTown(1);
  bare.blocks_x = bare.blocks_y = 1;
  bare.street_spacing_m = 50;
  bare.irregularity = bare.relief_m = bare.house_density = bare.tree_density = bare.car_density = 0;
  EXPECT_FALSE(makeTown(bare).mesh.triangles.empty());
  TownOptions full = smallTown(1);
  full.irregularity = full.house_density = full.row_share = full.car_density = 1;
  full.relief_m = 5;
  full.tree_density = 4;
  EXPECT_FALSE(makeTown(full).mesh.triangles.empty());
}

TEST(Footprint, OverlapAgreesWithSampling) {
  Random random(5);
  for (int i = 0; i < 300; ++i) {
    const Footprint a{{0, 0}, random.uniform(0, 3), {random.uniform(1, 6), random.uniform(1, 6)}};
    const Footprint b{{random.uniform(-6, 6), random.uniform(-6, 6)},
                      random.uniform(0, 3),
                      {random.uniform(1, 6), random.uniform(1, 6)}};
    bool sampled = false;
    for (int j = 0; j <= 40; ++j) {
      for (int k = 0; k <= 40; ++k) {
        const Eigen::Vector2d p =
            b.toWorld({(j / 40.0 - 0.5) * b.size.x(), (k / 40.0 - 0.5) * b.size.y()});
        sampled |= a.distanceTo(p) == 0;
      }
    }
    // Samples are up to 0.1 m from a corner that alone may overlap.
    EXPECT_EQ(overlap(a, b, sampled ? 0 : -0.2), sampled);
  }
}

TEST(Town, AlikeStreetsFollowOnePatternInTownsOfAnySeed) {
  TownOptions options;
  options.irregularity = options.relief_m = 0;
  options.alike = 1;
  options.seed = 1;
  const Town a = makeTown(options);
  options.seed = 2;
  const Town b = makeTown(options);
  options.alike = 0;
  const Town other = makeTown(options);
  std::size_t same = 0, chance = 0;
  for (std::size_t i = 0; i < 100; ++i) {
    same += (a.houses[i].center - b.houses[i].center).norm() < 1e-6;
    chance += (a.houses[i].center - other.houses[i].center).norm() < 1e-6;
  }
  EXPECT_EQ(same, 100u);
  EXPECT_LT(chance, 5u);
}

TEST(Town, HallsAreLargerThanHouses) {
  TownOptions options;
  options.lots = Lots::halls;
  const Town campus = makeTown(options);
  double largest = 0;
  for (const Footprint& house : campus.houses) largest = std::max(largest, house.size.x());
  EXPECT_GT(largest, 25);
}

}  // namespace
}  // namespace xview
