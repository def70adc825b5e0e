// SPDX-License-Identifier: BSD-3-Clause
#include "base/cells.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>

#include "base/random.h"
#include "xview/base/budget.h"

namespace xview {
namespace {

TEST(FloorToInt, LeavesRoomForNeighboursWhateverTheValueIs) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double value : {0., -0.5, 0.5, -1., 1., -7.01, 1e9, -1e9 + 0.5})
    EXPECT_EQ(floorToInt(value), static_cast<std::int32_t>(std::floor(value))) << value;
  for (const double far : {1.08e9, 2e9, 1e10, 3e38, 1e300, kInfinity}) {
    EXPECT_EQ(floorToInt(far), 1 << 30) << far;
    EXPECT_EQ(floorToInt(-far), -(1 << 30)) << far;
  }
  EXPECT_EQ(floorToInt(std::nan("")), -(1 << 30));
}

TEST(HeightLattice, LooksAtTheBudgetWhileItFillsGaps) {
  HeightLattice lattice{1.F, {}, {}};
  for (int x = 0; x < 3; ++x) lattice.index.findOrAdd(x, 0);
  lattice.heights = {2.F, NAN, NAN};
  const Budget budget({1e-9, 0});
  EXPECT_TRUE(cutByBudget([&] { lattice.fillGaps(1); }));
}

TEST(CellIndex, NumbersCellsLikeAMapDoes) {
  Random random(1);
  CellIndex index;
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> oracle;
  for (int i = 0; i < 50000; ++i) {
    const int extent = i % 2 ? 400 : 20;  // near the last tiles and far from them
    const auto x = static_cast<std::int32_t>(random.below(extent)) - extent / 2;
    const auto y = static_cast<std::int32_t>(random.below(extent)) - extent / 2;
    const auto it = oracle.find({x, y});
    ASSERT_EQ(index.find(x, y), it == oracle.end() ? -1 : it->second);
    if (i % 3 > 0) continue;
    const std::int32_t number = index.findOrAdd(x, y);
    ASSERT_EQ(number, oracle.emplace(std::make_pair(x, y), static_cast<std::int32_t>(oracle.size()))
                          .first->second);
    ASSERT_EQ(index.cells()[number].x, x);
    ASSERT_EQ(index.cells()[number].y, y);
  }
  EXPECT_EQ(index.size(), oracle.size());
}

TEST(CellIndex, TakesTheOutermostCells) {
  constexpr std::int32_t kMost = 2147483647;
  CellIndex index;
  EXPECT_EQ(index.findOrAdd(kMost, -kMost - 1), 0);
  EXPECT_EQ(index.findOrAdd(-kMost - 1, kMost), 1);
  EXPECT_EQ(index.findOrAdd(0, 0), 2);
  EXPECT_EQ(index.find(kMost, -kMost - 1), 0);
  EXPECT_EQ(index.find(-1, -1), -1);
}

struct Count {
  ClassCell key;
  int points = 0;
};

ClassCell randomCell(Random& random) {
  const auto at = [&] { return static_cast<std::int32_t>(random.below(30)) - 15; };
  return {at(), at(), at(), random.below(3)};
}

TEST(CellTable, CountsLikeAMapDoes) {
  Random random(2);
  CellTable<Count> table;
  std::map<std::tuple<std::int32_t, std::int32_t, std::int32_t, std::uint32_t>, std::size_t> oracle;
  for (int i = 0; i < 100000; ++i) {
    const ClassCell cell = randomCell(random);
    const std::size_t expected =
        oracle.emplace(std::make_tuple(cell.x, cell.y, cell.z, cell.label), oracle.size())
            .first->second;
    ASSERT_EQ(table.numberOf(cell, [&] { return Count{cell}; }), expected);
    ++table[expected].points;
    if (i == 50) table.reserve(1000);
  }
  ASSERT_EQ(table.size(), oracle.size());
  int points = 0;
  for (std::size_t i = 0; i < table.size(); ++i) points += table[i].points;
  EXPECT_EQ(points, 100000);
}

TEST(CellLists, FindWhatIsWithinTheSideOfACell) {
  constexpr double kSide_m = 2;
  Random random(3);
  const auto somewhere = [&] {
    const auto at = [&] { return random.uniform(-8, 8); };
    return Eigen::Vector3d(at(), at(), at());
  };
  std::vector<Eigen::Vector3d> points;
  CellLists lists;
  for (std::size_t i = 0; i < 400; ++i) {
    points.push_back(somewhere());
    lists.add(cellOf(points[i], kSide_m, i % 2), i);
  }
  for (std::size_t i = 0; i < 400; i += 3) {
    const ClassCell before = cellOf(points[i], kSide_m, i % 2);
    points[i] = somewhere();
    lists.move(before, cellOf(points[i], kSide_m, i % 2), i);
  }
  for (int query = 0; query < 50; ++query) {
    const Eigen::Vector3d p = somewhere();
    std::set<std::size_t> found, expected;
    lists.forAround(cellOf(p, kSide_m, 1), [&](std::size_t i) {
      EXPECT_EQ(i % 2, 1u) << "of another class";
      if ((points[i] - p).norm() <= kSide_m) found.insert(i);
    });
    for (std::size_t i = 1; i < points.size(); i += 2) {
      if ((points[i] - p).norm() <= kSide_m) expected.insert(i);
    }
    EXPECT_EQ(found, expected);
    for (std::size_t i = 0; i < points.size(); ++i)
      EXPECT_EQ(lists.anyAround(
                    cellOf(p, kSide_m, 1),
                    [&](std::size_t k) { return k == i && (points[k] - p).norm() <= kSide_m; }),
                expected.count(i) > 0);
  }
}

/// Pieces are what disjoint sets of all touching pairs are.
TEST(ConnectedCells, AreThoseThatDisjointSetsJoin) {
  Random random(4);
  CellIndex index;
  for (int i = 0; i < 300; ++i)
    index.findOrAdd(static_cast<std::int32_t>(random.below(30)) - 15,
                    static_cast<std::int32_t>(random.below(30)) - 15);
  const auto belongs = [](std::int32_t cell) { return cell % 7 != 0; };
  DisjointSets sets(index.size());
  std::size_t expected = 0;
  for (std::uint32_t i = 0; i < index.size(); ++i) {
    for (std::uint32_t j = 0; j < i; ++j) {
      const PlaneCell a = index.cells()[i], b = index.cells()[j];
      const bool touch = std::max(std::abs(a.x - b.x), std::abs(a.y - b.y)) <= 1;
      if (touch && belongs(static_cast<std::int32_t>(i)) && belongs(static_cast<std::int32_t>(j)))
        sets.unite(i, j);
    }
  }
  const auto pieces = connectedCells(index, belongs);
  for (std::uint32_t i = 0; i < index.size(); ++i)
    expected += belongs(static_cast<std::int32_t>(i)) && sets.find(i) == i;
  EXPECT_EQ(pieces.size(), expected);
  std::set<std::int32_t> seen;
  for (const auto& piece : pieces) {
    for (const std::int32_t cell : piece) {
      EXPECT_TRUE(belongs(cell) && seen.insert(cell).second);
      EXPECT_EQ(sets.find(static_cast<std::uint32_t>(cell)),
                sets.find(static_cast<std::uint32_t>(piece.front())));
    }
  }
}

TEST(HeightLattice, IsBilinearAndFillsGapsFromTheNearest) {
  HeightLattice lattice{2, {}, {}};
  for (int y = -3; y <= 3; ++y) {
    for (int x = -3; x <= 3; ++x) {
      lattice.index.findOrAdd(x, y);
      const bool is_gap = x == 0 && y == 0;
      lattice.heights.push_back(is_gap ? NAN : static_cast<float>(2 * x + 1 - 3 * (2 * y + 1)));
    }
  }
  EXPECT_NEAR(lattice.heightAt(4.3f, -2.8f), 4.3f + 3 * 2.8f, 1e-5);
  lattice.fillGaps(1);
  // The first of the neighbours, which are equally near.
  EXPECT_EQ(lattice.heightAt(1, 1), lattice.heightAt(-1, -1));
  EXPECT_EQ(lattice.heightAt(100, 100), 0) << "beyond the cells";
}

}  // namespace
}  // namespace xview
