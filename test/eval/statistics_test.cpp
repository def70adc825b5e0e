// SPDX-License-Identifier: BSD-3-Clause
#include "xview/eval/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace xview {
namespace {

TEST(Quantile, IsTheMiddleValueOfAnOddNumber) { EXPECT_DOUBLE_EQ(quantile({9, 1, 4}, 0.5), 4); }
TEST(Quantile, IsLinearBetweenNeighbours) { EXPECT_DOUBLE_EQ(quantile({0, 10}, 0.9), 9); }
TEST(Quantile, EndsAreTheExtremes) {
  EXPECT_DOUBLE_EQ(quantile({3, 7, 5}, 0), 3);
  EXPECT_DOUBLE_EQ(quantile({3, 7, 5}, 1), 7);
}
TEST(Quantile, OfNothingIsUnknown) { EXPECT_TRUE(std::isnan(quantile({}, 0.5))); }

TEST(ShareWithin, CountsTheLimitItself) { EXPECT_DOUBLE_EQ(shareWithin({1, 2, 3}, 2, 4), 0.5); }
TEST(ShareWithin, NeverCountsWhatHasNoValue) {
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_DOUBLE_EQ(shareWithin({inf, std::nan(""), 1}, 1e300, 4), 0.25);
}
TEST(ShareWithin, OfNoQueriesIsUnknown) { EXPECT_TRUE(std::isnan(shareWithin({}, 1, 0))); }

}  // namespace
}  // namespace xview
