// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/best_looks.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace xview {
namespace {

constexpr std::uint32_t kWall = 2, kFence = 5;

/// Points of one class on a small patch, all with the same depth error.
class Looks {
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
    const std::vector<bool> keep = bestLooks(cloud_);
    long count = 0;
    for (std::size_t i = 0; i < keep.size(); ++i)
      count += keep[i] && cloud_.points[i].sigma == sigma_m;
    return count;
  }

 private:
  LabelledCloud cloud_;
};

TEST(BestLooks, WhatWasSeenFromAfarGivesWayToWhatWasSeenFromNear) {
  Looks looks;
  looks.add(20, kWall, 0.12f);
  looks.add(30, kWall, 0.45f);
  EXPECT_EQ(looks.kept(0.12f), 20);
  EXPECT_EQ(looks.kept(0.45f), 0);
}

TEST(BestLooks, WhatWasSeenOnlyFromAfarStays) {
  Looks looks;
  looks.add(20, kWall, 0.12f);
  looks.add(30, kWall, 0.45f, 10);
  EXPECT_EQ(looks.kept(0.45f), 30);
}

TEST(BestLooks, AnotherClassSaysNothing) {
  Looks looks;
  looks.add(20, kWall, 0.12f);
  looks.add(30, kFence, 0.45f);
  EXPECT_EQ(looks.kept(0.45f), 30);
}

TEST(BestLooks, AFewGoodPointsDoNotDecide) {
  Looks looks;
  looks.add(3, kWall, 0.12f);
  looks.add(30, kWall, 0.45f);
  EXPECT_EQ(looks.kept(0.45f), 30);
}

TEST(BestLooks, WhatIsKnownToADecimetreStaysAnywhere) {
  Looks looks;
  looks.add(20, kWall, 0.01f);
  looks.add(30, kWall, 0.09f);
  looks.add(30, kWall, 0.3f);
  EXPECT_EQ(looks.kept(0.09f), 30);
  EXPECT_EQ(looks.kept(0.3f), 0);
}

TEST(BestLooks, NothingGivesNothing) { EXPECT_TRUE(bestLooks({}).empty()); }

}  // namespace
}  // namespace xview
