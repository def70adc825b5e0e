// SPDX-License-Identifier: BSD-3-Clause
#include "xview/verify/verdict.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "xview/types/random.h"

namespace xview::verify {
namespace {

const VerdictOptions kOptions;

Verdict judged(const Evidence& e) { return judge(e, kOptions); }

Evidence goodView() {
  Evidence e;
  e.score = 300;
  e.runner_up = 60;
  e.expected = 310;
  e.standing = {140, 150};
  e.sides = {PartEvidence{160, 165}, PartEvidence{140, 145}};
  e.known_share = 0.9;
  return e;
}

/// Of a bare graph, which has no parts, and of walks, which know no expected score.
Evidence goodGraph() {
  Evidence e;
  e.score = 48;
  e.runner_up = 2;
  e.expected = 55;
  e.known_share = 0.8;
  return e;
}

Evidence randomEvidence(Random& random) {
  Evidence e;
  e.score = random.uniform(-50, 400);
  e.runner_up = random.uniform(-50, 200);
  e.expected = random.uniform(-50, 500);
  e.standing = {random.uniform(-50, 200), random.uniform(-10, 200)};
  for (PartEvidence& side : e.sides) side = {random.uniform(-50, 200), random.uniform(-10, 200)};
  e.known_share = random.uniform();
  e.windows = 1 + static_cast<int>(random.below(6));
  e.with_candidates = static_cast<int>(random.below(40));
  e.kept = static_cast<int>(random.below(40));
  e.kept_by_chance = random.uniform(0, 40);
  if (random.below(2)) e.overlap = random.uniform();
  return e;
}

TEST(Verdict, GoodEvidenceIsAcceptedWhateverItIsOf) {
  EXPECT_EQ(judged(goodView()).status, Status::accepted) << judged(goodView()).reason;
  EXPECT_GT(judged(goodView()).confidence, 0.999);
  EXPECT_EQ(judged(goodGraph()).status, Status::accepted) << judged(goodGraph()).reason;
  Evidence walks;
  walks.score = 60;
  walks.runner_up = 6;
  EXPECT_EQ(judged(walks).status, Status::accepted) << judged(walks).reason;
}

TEST(Verdict, AcceptedIsExactlyWhatReachesTheConfidence) {
  Random random(5);
  int accepted = 0;
  for (int i = 0; i < 20000; ++i) {
    const Evidence e = randomEvidence(random);
    VerdictOptions options;
    options.min_confidence = random.uniform(0.5, 0.9999);
    const Verdict v = judge(e, options);
    EXPECT_EQ(v.status == Status::accepted, v.confidence >= options.min_confidence);
    EXPECT_GE(v.confidence, 0);
    EXPECT_LE(v.confidence, 1);
    EXPECT_EQ(v.reason.find('\n'), std::string::npos);
    EXPECT_EQ(v.reason.find("nan"), std::string::npos) << v.reason;
    EXPECT_FALSE(v.reason.empty());
    if (v.status != Status::accepted) continue;
    ++accepted;
    EXPECT_GT(e.score, e.runner_up);
    EXPECT_GE(e.known_share, options.min_known_share);
  }
  EXPECT_GT(accepted, 100) << "or nothing was tested";
}

TEST(Verdict, ConfidenceNeverFallsWithBetterEvidence) {
  const auto improvements = {
      +[](Evidence& e) { e.score += 10; },          +[](Evidence& e) { e.runner_up -= 10; },
      +[](Evidence& e) { e.standing.score += 10; }, +[](Evidence& e) { e.sides[0].score += 10; },
      +[](Evidence& e) { e.sides[1].score += 10; }, +[](Evidence& e) { e.known_share += 0.05; },
  };
  Random random(6);
  int grown = 0;
  for (int i = 0; i < 2000; ++i) {
    Evidence worse = randomEvidence(random);
    worse.expected = std::abs(worse.expected) + 1;
    for (const auto& improve : improvements) {
      Evidence better = worse;
      improve(better);
      EXPECT_GE(judged(better).confidence, judged(worse).confidence);
      grown += judged(better).confidence > judged(worse).confidence;
    }
  }
  EXPECT_GT(grown, 1000);
}

TEST(Verdict, ALayoutWhoseHousesContradictIsRefused) {
  Evidence e = goodView();
  e.standing.score = -20;
  EXPECT_EQ(judged(e).status, Status::rejected) << "roads alone repeat between towns";
  EXPECT_LT(judged(e).confidence, 0.5);
  e.standing.score = 30;
  EXPECT_LT(judged(e).confidence, judged(goodView()).confidence);
}

TEST(Verdict, AStreetThatFitsOnOneSideOnlyIsRefused) {
  Evidence e = goodView();
  e.sides[1].score = -20;
  EXPECT_EQ(judged(e).status, Status::rejected);
  e.sides[1] = {};
  EXPECT_EQ(judged(e).status, Status::accepted) << "a view to one side is judged by that side";
  e.standing = {};
  e.sides = {};
  EXPECT_EQ(judged(e).status, Status::accepted) << "one without anything upright by the rest";
}

TEST(Verdict, TwoPlacesThatFitEquallyWellAreAmbiguousAndTwoBadOnesRejected) {
  Evidence e = goodView();
  e.runner_up = 290;
  EXPECT_EQ(judged(e).status, Status::ambiguous) << judged(e).reason;
  EXPECT_LT(judged(e).confidence, 0.5);
  e.score = 20;
  e.runner_up = 19;
  EXPECT_EQ(judged(e).status, Status::rejected);
}

TEST(Verdict, HalfTheLeadOfAStrangerIsNoAcceptance) {
  Evidence stranger;  // of a town whose streets look alike
  stranger.score = 138;
  stranger.runner_up = 74;
  stranger.expected = 260;
  EXPECT_NE(judged(stranger).status, Status::accepted);
  Evidence poor_labels = stranger;  // the same score where nothing else comes near
  poor_labels.runner_up = 31;
  EXPECT_EQ(judged(poor_labels).status, Status::accepted);
}

TEST(Verdict, MoreWindowsNeedMore) {
  Evidence e = goodView();
  e.score = 130;
  e.expected = 130;
  e.standing = {};
  e.sides = {};
  const double one = judged(e).confidence;
  e.windows = 4;
  EXPECT_LT(judged(e).confidence, one) << "sums of wrong places spread with the root of windows";
}

TEST(Verdict, WithoutEvidenceIsRejected) {
  EXPECT_EQ(judged({}).status, Status::rejected);
  EXPECT_EQ(judged({}).confidence, 0);
  Evidence no_number = goodView();
  no_number.score = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(judged(no_number).status, Status::rejected);
  EXPECT_EQ(judged(no_number).confidence, 0);
  Evidence worse_than_chance = goodView();
  worse_than_chance.score = -50;
  worse_than_chance.runner_up = -800;
  EXPECT_EQ(judged(worse_than_chance).status, Status::rejected);
}

TEST(Verdict, OutsideTheMapIsRejectedAndSaysSo) {
  Evidence e = goodView();
  e.known_share = 0.1;
  EXPECT_EQ(judged(e).status, Status::rejected);
  EXPECT_LT(judged(e).confidence, 0.5);
  EXPECT_NE(judged(e).reason.find("10 %"), std::string::npos) << judged(e).reason;
}

TEST(Witnesses, SayWhatEachKnows) {
  Evidence e = goodView();
  e.with_candidates = 30;
  e.kept_by_chance = 8;
  e.kept = 20;
  EXPECT_GT(judged(e).witnesses.correspondences, 5);
  e.kept = 7;
  EXPECT_LT(judged(e).witnesses.correspondences, -5);
  e.overlap = 0.6;
  EXPECT_GT(judged(e).witnesses.dense, 0);
  e.overlap = 0.1;
  EXPECT_LT(judged(e).witnesses.dense, 0);
  EXPECT_EQ(judged(goodGraph()).witnesses.dense, 0) << "without points nothing is said";
}

}  // namespace
}  // namespace xview::verify
