// SPDX-License-Identifier: BSD-3-Clause
#include "../../src/match/raster_candidates.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "xview/types/random.h"

namespace xview::raster {
namespace {

std::vector<Candidate> manyCandidates() {
  Random random(3);
  std::vector<Candidate> all;
  for (int i = 0; i < 5000; ++i)
    all.push_back({static_cast<std::int32_t>(1 + random.below(60)), i % 7, i % 50, i / 50});
  return all;
}

bool isSame(const Candidate& a, const Candidate& b) { return !(a < b) && !(b < a); }

TEST(BestCandidates, AreThoseOfSortingAllAlsoAmongEqualScores) {
  std::vector<Candidate> all = manyCandidates();
  for (const std::size_t keep : {1u, 10u, 300u, 10000u}) {
    BestCandidates best(keep), first_half(keep);
    for (std::size_t i = 0; i < all.size(); ++i) (i % 2 ? best : first_half).offer(all[i]);
    best.merge(first_half);
    const std::vector<Candidate> found = std::move(best).sorted();
    std::vector<Candidate> expected = all;
    std::sort(expected.begin(), expected.end());
    expected.resize(std::min(keep, expected.size()));
    ASSERT_EQ(found.size(), expected.size());
    EXPECT_TRUE(std::equal(found.begin(), found.end(), expected.begin(), isSame)) << keep;
  }
}

TEST(BestCandidates, BelowTheThresholdIsNothingThatCouldBeAmongThem) {
  BestCandidates best(10);
  std::vector<Candidate> all = manyCandidates();
  for (const Candidate& candidate : all) best.offer(candidate);
  std::sort(all.begin(), all.end());
  EXPECT_LE(best.threshold(), all[9].score);
  EXPECT_GT(best.threshold(), 1);
}

}  // namespace
}  // namespace xview::raster
