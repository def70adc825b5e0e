// SPDX-License-Identifier: BSD-3-Clause
#include "pose/distribution_map.h"

#include <gtest/gtest.h>

#include <map>
#include <tuple>

#include "base/random.h"
#include "pose/refine.h"
#include "support/label_sets.h"

namespace xview::pose {
namespace {

constexpr float kSide = 0.5f;
constexpr std::uint32_t kWall = 1, kFence = 2;

LabelSet twoClasses() {
  return test::labelSetOf("two", {{kWall, "building", Role::surface, Kind::building},
                                  {kFence, "fence", Role::surface, Kind::fence}});
}

RefineOptions options() {
  RefineOptions options;
  options.cell_m = kSide;
  return options;
}

/// Points about the place where four tiles of any width meet, and far to both sides of it.
LabelledCloud cloudOverTiles() {
  Random random(3);
  LabelledCloud cloud;
  cloud.origin = {1000, -2000, 30};
  const auto anywhere = [&] { return static_cast<float>(random.uniform(-1, 1)); };
  for (int i = 0; i < 30000; ++i) {
    const float reach = i % 2 ? 2.f : 30.f;
    cloud.points.push_back(
        {reach * anywhere(), reach * anywhere(), anywhere(), random.below(2) ? kWall : kFence});
  }
  return cloud;
}

/// Without tables or tiles.
class Oracle {
 public:
  explicit Oracle(const LabelledCloud& cloud) {
    for (const Point& p : cloud.points) {
      Cell& cell = cells_[keyOf(p.getVector3fMap(), p.label)];
      cell.sum += p.getVector3fMap().cast<double>();
      ++cell.points;
    }
  }

  /// Distance to the nearest mean; infinite beyond the gate.
  double nearest(const Eigen::Vector3f& p, std::uint32_t label, float gate) const {
    const auto [x, y, z, l] = keyOf(p, label);
    double best = INFINITY;
    for (const auto& [key, cell] : cells_) {
      const auto [cx, cy, cz, cl] = key;
      const bool is_neighbour =
          std::abs(cx - x) <= 1 && std::abs(cy - y) <= 1 && std::abs(cz - z) <= 1 && cl == l;
      if (!is_neighbour || cell.points < 4) continue;
      best = std::min(best, (cell.sum / cell.points - p.cast<double>()).norm());
    }
    return best < gate ? best : INFINITY;
  }

 private:
  using Key = std::tuple<int, int, int, std::uint32_t>;
  static Key keyOf(const Eigen::Vector3f& p, std::uint32_t label) {
    const auto index = [](float c) { return static_cast<int>(std::floor(c / kSide)); };
    return {index(p.x()), index(p.y()), index(p.z()), label};
  }
  struct Cell {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int points = 0;
  };
  std::map<Key, Cell> cells_;
};

TEST(DistributionMap, NearestIsThatOfAllCellsAroundWhereverTilesMeet) {
  const LabelledCloud cloud = cloudOverTiles();
  const DistributionMap map({cloud, twoClasses(), {}}, options());
  const Oracle oracle(cloud);
  Random random(4);
  int found = 0;
  for (int i = 0; i < 300; ++i) {
    const double reach = i % 3 == 0 ? 20 : 1;
    const Eigen::Vector3f p(random.uniform(-reach, reach), random.uniform(-reach, reach),
                            random.uniform(-1.2, 1.2));
    const std::uint32_t label = random.below(2) ? kWall : kFence;
    const Distribution* d = map.nearest(p, matchingGroup(twoClasses(), label), 0.4f);
    const double expected = oracle.nearest(p, label, 0.4f);
    ASSERT_EQ(d != nullptr, std::isfinite(expected)) << p.transpose();
    if (!d) continue;
    EXPECT_NEAR((d->mean - p).norm(), expected, 1e-4);
    ++found;
  }
  EXPECT_GT(found, 100);
}

TEST(DistributionMap, KnowOfAPointThatMovesWhatTheyKnowOfOneThatIsThere) {
  const LabelledCloud cloud = cloudOverTiles();
  const DistributionMap map({cloud, twoClasses(), {}}, options());
  Random random(5);
  int changes = 0, none = 0;
  for (int walk = 0; walk < 400; ++walk) {
    const std::uint32_t group = matchingGroup(twoClasses(), random.below(2) ? kWall : kFence);
    // Where cells are full, and where most of them are empty, so that some further off are asked.
    const double around = walk % 2 == 0 ? 1 : 32;
    Eigen::Vector3f p(random.uniform(-around, around), random.uniform(-around, around),
                      random.uniform(-1.2, 1.2));
    DistributionMap::Nearest last;
    const Distribution* before = nullptr;
    for (int step = 0; step < 60; ++step) {
      const float reach = step % 20 == 19 ? 0.5F
                          : walk % 3 == 0 ? 0.1F
                                          : 0.02F,
                  gate = 0.1F + 1.4F * std::abs(std::cos(0.1F * static_cast<float>(step)));
      for (int axis = 0; axis < 3; ++axis)
        p[axis] += static_cast<float>(random.uniform(-reach, reach));
      const Distribution* d = map.nearest(p, group, gate, last);
      ASSERT_EQ(d, map.nearest(p, group, gate)) << p.transpose();
      changes += step > 0 && d != before;
      none += d == nullptr;
      before = d;
    }
  }
  EXPECT_GT(changes, 50);
  EXPECT_GT(none, 50);
}

TEST(DistributionMap, WithoutPointsHaveNothingNear) {
  const LabelledCloud empty;
  const DistributionMap map({empty, twoClasses(), {}}, options());
  EXPECT_EQ(map.size(), 0u);
  EXPECT_EQ(map.nearest({0, 0, 0}, matchingGroup(twoClasses(), kWall), 1), nullptr);
}

TEST(DistributionMap, OfGroundTellHardlyHowFarItWasSeen) {
  const auto informationOf = [](Kind kind) {
    const LabelSet set = test::labelSetOf("ground", {{kWall, "surface", Role::surface, kind}});
    LabelledCloud cloud;  // level, and it ends in the middle of the cell
    Random random(6);
    for (int i = 0; i < 500; ++i)
      cloud.points.push_back({static_cast<float>(random.uniform(0, kSide / 2)),
                              static_cast<float>(random.uniform(0, kSide)), 0.25F, kWall});
    const DistributionMap map({cloud, set, {}}, options());
    const Eigen::Matrix3f& all =
        map.nearest({0.1F, 0.2F, 0.25F}, matchingGroup(set, kWall), 0.5F)->information;
    return Eigen::Vector2f(all(0, 0), all(2, 2));
  };
  const Eigen::Vector2f fence = informationOf(Kind::fence), road = informationOf(Kind::road);
  EXPECT_GT(fence[0], 50);
  EXPECT_NEAR(road[0], 0.1 * fence[0], 0.02 * fence[0]);
  EXPECT_FLOAT_EQ(road[1], fence[1]) << "across the surface it tells as much";
}

TEST(DistributionMap, OfALargeMapKnowTheThicknessOfItsWalls) {
  const auto informationOf = [](double thickness_m) {
    Random random(5);
    LabelledCloud cloud;  // a wall of 300 m along x, of which not all cells are asked
    for (int i = 0; i < 400000; ++i)
      cloud.points.push_back({static_cast<float>(random.uniform(-150, 150)),
                              0.25f + static_cast<float>(thickness_m * random.normal()),
                              static_cast<float>(random.uniform(0, 3)), kWall});
    const DistributionMap map({cloud, twoClasses(), {}}, options());
    return map.nearest({0.25f, 0.25f, 1.25f}, matchingGroup(twoClasses(), kWall), 0.5f)
        ->information(1, 1);
  };
  const double roughness = options().model.roughness_m,
               even = 1 / (kSide * kSide / 12 + roughness * roughness);
  EXPECT_NEAR(informationOf(0), 1 / (roughness * roughness) - even, 1);
  // Four times the thickness is added to the spread.
  const double thick = 0.03, variance = roughness * roughness + 16 * thick * thick;
  EXPECT_NEAR(informationOf(thick),
              1 / (variance + thick * thick) - 1 / (kSide * kSide / 12 + variance), 3);
}

}  // namespace
}  // namespace xview::pose
