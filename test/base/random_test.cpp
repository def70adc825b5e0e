// SPDX-License-Identifier: BSD-3-Clause
#include "base/random.h"

#include <gtest/gtest.h>

#include <array>
#include <set>

namespace xview {
namespace {

TEST(Random, RepeatsItselfForTheSameSeed) {
  Random a(42), b(42), other(43);
  bool differs = false;
  for (int i = 0; i < 100; ++i) {
    const std::uint64_t value = a.next();
    EXPECT_EQ(value, b.next());
    differs = differs || value != other.next();
  }
  EXPECT_TRUE(differs);
}

TEST(Random, GivesEveryIndexItsOwnStream) {
  std::set<std::uint64_t> first;
  for (std::uint64_t index = 0; index < 1000; ++index) first.insert(Random(7, index).next());
  EXPECT_EQ(first.size(), 1000u);
}

TEST(Random, NearSeedsShareNoDraws) {
  std::set<std::uint64_t> drawn;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Random random(seed), of_index(seed, 5);
    for (int i = 0; i < 20; ++i) drawn.insert({random.next(), of_index.next()});
  }
  EXPECT_EQ(drawn.size(), 100u * 20 * 2);
}

TEST(Random, DrawsUniformlyBelowABound) {
  Random random(1);
  std::array<int, 7> counts{};
  for (int i = 0; i < 70000; ++i) ++counts.at(random.below(7));
  for (const int count : counts) EXPECT_NEAR(count, 10000, 500);
  EXPECT_EQ(random.below(1), 0u);
}

TEST(Random, StaysInTheHalfOpenUnitInterval) {
  Random random(2);
  double sum = 0;
  for (int i = 0; i < 10000; ++i) {
    const double value = random.uniform();
    EXPECT_GE(value, 0);
    EXPECT_LT(value, 1);
    sum += value;
  }
  EXPECT_NEAR(sum / 10000, 0.5, 0.02);
}

TEST(Random, HasNormalMomentsOfOrderOneTwoAndFour) {
  Random random(3);
  double mean = 0, square = 0, fourth = 0;
  constexpr int kDraws = 100000;
  for (int i = 0; i < kDraws; ++i) {
    const double value = random.normal();
    ASSERT_TRUE(std::isfinite(value));
    mean += value / kDraws;
    square += value * value / kDraws;
    fourth += value * value * value * value / kDraws;
  }
  EXPECT_NEAR(mean, 0, 0.02);
  EXPECT_NEAR(square, 1, 0.03);
  EXPECT_NEAR(fourth, 3, 0.2);
}

}  // namespace
}  // namespace xview
