// SPDX-License-Identifier: BSD-3-Clause
#include "graph/cell_index.h"

#include <gtest/gtest.h>

#include <map>

#include "xview/types/random.h"

namespace xview {
namespace {

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

}  // namespace
}  // namespace xview
