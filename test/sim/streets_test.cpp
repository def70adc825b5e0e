// SPDX-License-Identifier: BSD-3-Clause
#include "sim/streets.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/random.h"

namespace xview {
namespace {

TownOptions crooked(std::uint64_t seed) {
  TownOptions options;
  options.seed = seed;
  options.irregularity = 1;
  return options;
}

std::size_t reachableJunctions(const StreetNetwork& network) {
  std::vector<bool> reached(network.junctions.size(), false);
  std::vector<int> open{0};
  reached[0] = true;
  std::size_t count = 0;
  while (!open.empty()) {
    const int at = open.back();
    open.pop_back();
    ++count;
    for (const int i : network.junctions[at].streets) {
      const Street& street = network.streets[i];
      const int other = street.from == at ? street.to : street.from;
      if (!reached[other]) open.push_back(other);
      reached[other] = true;
    }
  }
  return count;
}

TEST(Streets, NetworkIsConnectedAndNoJunctionIsADeadEnd) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const StreetNetwork network = makeStreets(crooked(seed));
    EXPECT_EQ(reachableJunctions(network), network.junctions.size()) << "seed " << seed;
    for (const Junction& junction : network.junctions) {
      EXPECT_GE(junction.streets.size(), 2u) << "seed " << seed;
    }
  }
}

TEST(Streets, StreetsBeginAndEndAtTheirJunctions) {
  const StreetNetwork network = makeStreets(crooked(3));
  for (const Street& street : network.streets) {
    if (!street.isThrough()) continue;
    EXPECT_LT((street.centreline.front() - network.junctions[street.from].position).norm(), 1e-9);
    EXPECT_LT((street.centreline.back() - network.junctions[street.to].position).norm(), 1e-9);
  }
}

TEST(Streets, RegularTownIsAGrid) {
  TownOptions options;
  options.irregularity = 0;
  const StreetNetwork network = makeStreets(options);
  EXPECT_EQ(network.streets.size(), 40u);
  for (const Street& street : network.streets) {
    EXPECT_NEAR(ArcLength(street.centreline).length(), options.street_spacing_m, 1e-6);
  }
}

TEST(ArcLength, WalksAlongThePolylineAndStopsAtItsEnds) {
  const ArcLength line({{0, 0}, {3, 0}, {3, 4}});
  EXPECT_DOUBLE_EQ(line.length(), 7);
  EXPECT_LT((line.at(5).position - Eigen::Vector2d(3, 2)).norm(), 1e-12);
  EXPECT_LT((line.at(5).direction - Eigen::Vector2d(0, 1)).norm(), 1e-12);
  EXPECT_LT((line.at(-1).position - Eigen::Vector2d(0, 0)).norm(), 1e-12);
  EXPECT_LT((line.at(99).position - Eigen::Vector2d(3, 4)).norm(), 1e-12);
}

TEST(StreetField, EqualsTheDistanceToTheOnlyStreet) {
  StreetNetwork network;
  Street street;
  street.from = 0;
  street.to = 1;
  street.half_width_m = 3;
  street.sidewalk_m = 2;
  for (int i = 0; i <= 50; ++i) street.centreline.push_back({2.0 * i, 0.0});
  network.streets.push_back(street);
  const StreetField field(network);
  Random random(1);
  for (int i = 0; i < 500; ++i) {
    const double x = random.uniform(0, 100), y = random.uniform(-11, 11);
    EXPECT_NEAR(field.toRoad({x, y}), std::abs(y) - 3, 1e-9);
    EXPECT_NEAR(field.toSidewalk({x, y}), std::abs(y) - 5, 1e-9);
  }
  EXPECT_EQ(field.toRoad({50, 1000}), StreetField::kFar);
  EXPECT_EQ(field.toRoad({1e9, NAN}), StreetField::kFar);
}

TEST(StreetField, IsContinuous) {
  const StreetField field(makeStreets(crooked(5)));
  Random random(2);
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector2d p{random.uniform(-30, 330), random.uniform(-30, 330)};
    const Eigen::Vector2d q = p + Eigen::Vector2d(0.01, 0.01);
    EXPECT_LT(std::abs(field.toRoad(p) - field.toRoad(q)), 0.05);
  }
}

TEST(StreetField, PathsAreSidewalkButNotRoad) {
  StreetField field(makeStreets(TownOptions()));
  const Eigen::Vector2d far_out(-15, -15);
  field.addPath(far_out, far_out + Eigen::Vector2d(5, 0), 1.5);
  EXPECT_NEAR(field.toSidewalk(far_out + Eigen::Vector2d(2, 0.5)), -1, 1e-9);
  EXPECT_GT(field.toRoad(far_out), 0);
}

}  // namespace
}  // namespace xview
