// SPDX-License-Identifier: BSD-3-Clause
#include "xview/verify/verdict.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "xview/types/random.h"

namespace xview {
namespace {

const VerdictOptions kOptions;

Verdict judgePlace(const PlaceEvidence& e) { return judge(e, 60, kOptions); }
Verdict judgeView(const ViewEvidence& e) { return judge(e, kOptions); }

PlaceEvidence goodPlace() {
  PlaceEvidence e;
  e.score = 900;
  e.runner_up = 300;
  e.expected = 1000;
  e.known_share = 0.95;
  return e;
}

ViewEvidence goodView() {
  ViewEvidence e;
  e.score = 300;
  e.runner_up = 60;
  e.expected = 310;
  e.standing.score = 140;
  e.standing.expected = 150;
  e.sides = {PartEvidence{160, 165}, PartEvidence{140, 145}};
  e.known_share = 0.9;
  e.wrong_scores = {60, 48, 41, 40, 36, 33, 32, 31, 30, 30, 28};
  return e;
}

PlaceEvidence randomPlace(Random& random) {
  PlaceEvidence e;
  e.score = random.uniform(-200, 1000);
  e.runner_up = random.uniform(-200, 1000);
  e.expected = random.uniform(-100, 1500);
  e.known_share = random.uniform();
  return e;
}

ViewEvidence randomView(Random& random) {
  ViewEvidence e;
  e.score = random.uniform(-50, 400);
  e.runner_up = random.uniform(-50, 200);
  e.expected = random.uniform(-50, 500);
  e.standing.score = random.uniform(-50, 200);
  e.standing.expected = random.uniform(-10, 200);
  for (PartEvidence& side : e.sides) side = {random.uniform(-50, 200), random.uniform(-10, 200)};
  e.known_share = random.uniform();
  double score = e.runner_up;
  for (std::uint32_t i = random.below(12); i > 0; --i)
    e.wrong_scores.push_back(score -= random.uniform(0, 30));
  return e;
}

ConsensusEvidence goodConsensus() {
  ConsensusEvidence e;
  e.inliers = 25;
  e.runner_up = 6;
  e.vertices = 40;
  e.chance_inliers = 3;
  return e;
}

TEST(PlaceVerdict, GoodEvidenceIsAcceptedWithConfidence) {
  const Verdict v = judgePlace(goodPlace());
  EXPECT_EQ(v.status, Status::accepted);
  EXPECT_GT(v.confidence, 0.7);
}

TEST(PlaceVerdict, NothingIsAcceptedBelowAnyOfItsNeeds) {
  Random random(1);
  int accepted = 0;
  for (int i = 0; i < 20000; ++i) {
    const PlaceEvidence e = randomPlace(random);
    const double needed = random.uniform(1, 200);
    const Verdict v = judge(e, needed, kOptions);
    EXPECT_EQ(v.status == Status::accepted, v.confidence >= 0.5);
    if (v.status != Status::accepted) continue;
    ++accepted;
    EXPECT_GE(e.score - e.runner_up, needed);
    EXPECT_GE(e.score, kOptions.min_agreement * e.expected);
    EXPECT_GT(e.expected, 0);
    EXPECT_GE(e.known_share, kOptions.min_known_share);
  }
  EXPECT_GT(accepted, 100) << "or nothing was tested";
}

TEST(PlaceVerdict, ConfidenceGrowsWithTheMarginAndNeverWithItsLoss) {
  for (double known = 0; known <= 1; known += 0.25) {
    double before = -1;
    for (double runner_up = 900; runner_up >= 0; runner_up -= 10) {
      PlaceEvidence e = goodPlace();
      e.runner_up = runner_up;
      e.known_share = known;
      const double confidence = judgePlace(e).confidence;
      EXPECT_GE(confidence, before);
      before = confidence;
    }
  }
}

TEST(PlaceVerdict, ConfidenceGrowsWithAgreementAndSeenArea) {
  double before = -1;
  for (double expected = 5000; expected > 900; expected -= 50) {
    PlaceEvidence e = goodPlace();
    e.expected = expected;
    const double confidence = judgePlace(e).confidence;
    EXPECT_GE(confidence, before);
    before = confidence;
  }
  before = -1;
  for (double known = 0; known <= 1; known += 0.02) {
    PlaceEvidence e = goodPlace();
    e.known_share = known;
    const double confidence = judgePlace(e).confidence;
    EXPECT_GE(confidence, before);
    before = confidence;
  }
}

TEST(PlaceVerdict, ConfidenceIsAShare) {
  Random random(2);
  for (int i = 0; i < 5000; ++i) {
    const double c = judgePlace(randomPlace(random)).confidence;
    EXPECT_GE(c, 0);
    EXPECT_LE(c, 1);
  }
}

TEST(PlaceVerdict, TwoPlacesThatFitEquallyWellAreAmbiguous) {
  PlaceEvidence e = goodPlace();
  e.runner_up = 890;
  const Verdict v = judgePlace(e);
  EXPECT_EQ(v.status, Status::ambiguous);
  EXPECT_LT(v.confidence, 0.5);
}

TEST(PlaceVerdict, EqualPlacesThatBothFitBadlyAreRejected) {
  PlaceEvidence e = goodPlace();
  e.score = 200;
  e.runner_up = 195;
  EXPECT_EQ(judgePlace(e).status, Status::rejected);
}

TEST(PlaceVerdict, WithoutEvidenceIsRejected) {
  EXPECT_EQ(judgePlace({}).status, Status::rejected);
  EXPECT_EQ(judgePlace({}).confidence, 0);
  PlaceEvidence no_number = goodPlace();
  no_number.score = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(judgePlace(no_number).status, Status::rejected);
  PlaceEvidence negative = goodPlace();
  negative.score = -50;
  negative.runner_up = -800;
  EXPECT_EQ(judgePlace(negative).status, Status::rejected)
      << "far ahead of the others, but worse than chance";
}

TEST(PlaceVerdict, OutsideTheMapIsRejectedAndSaysSo) {
  PlaceEvidence e = goodPlace();
  e.known_share = 0.1;
  const Verdict v = judgePlace(e);
  EXPECT_EQ(v.status, Status::rejected);
  EXPECT_NE(v.reason.find("10 %"), std::string::npos) << v.reason;
}

TEST(PlaceVerdict, GivesOneSentenceForEverything) {
  Random random(3);
  for (int i = 0; i < 2000; ++i) {
    const std::string reason = judgePlace(randomPlace(random)).reason;
    EXPECT_FALSE(reason.empty());
    EXPECT_EQ(reason.find('\n'), std::string::npos);
    EXPECT_EQ(reason.find("nan"), std::string::npos) << reason;
  }
}

TEST(ViewVerdict, GoodEvidenceIsAcceptedWithConfidence) {
  const Verdict v = judgeView(goodView());
  EXPECT_EQ(v.status, Status::accepted) << v.reason;
  EXPECT_GT(v.confidence, 0.999);
  EXPECT_NE(v.reason.find("240 nats"), std::string::npos) << v.reason;
}

TEST(ViewVerdict, ManyWrongAnswersAreAWholeNumber) {
  ViewEvidence e = goodView();
  e.runner_up = 0.7 * e.score;
  e.score /= 40;
  e.runner_up /= 40;
  e.expected = e.score;
  const Verdict v = judgeView(e);
  EXPECT_NE(v.status, Status::accepted);
  EXPECT_EQ(v.reason.find("e+"), std::string::npos) << v.reason;
  EXPECT_NE(v.reason.find("wrong answers per right one"), std::string::npos) << v.reason;
}

TEST(ViewVerdict, AcceptedIsWhatReachesTheConfidenceAndAllGates) {
  Random random(5);
  int accepted = 0;
  for (int i = 0; i < 20000; ++i) {
    const ViewEvidence e = randomView(random);
    VerdictOptions options;
    options.min_confidence = random.uniform(0.5, 0.9999);
    const Verdict v = judge(e, options);
    EXPECT_EQ(v.status == Status::accepted, v.confidence >= options.min_confidence);
    EXPECT_GE(v.confidence, 0);
    EXPECT_LE(v.confidence, 1);
    EXPECT_EQ(v.reason.find('\n'), std::string::npos);
    EXPECT_FALSE(v.reason.empty());
    if (v.status != Status::accepted) continue;
    ++accepted;
    EXPECT_GT(e.score, e.runner_up);
    EXPECT_GE(e.score, options.min_agreement * e.expected);
    EXPECT_GE(e.known_share, options.min_known_share);
    EXPECT_LE(expectedFalseAlarms(e, options), 1 / options.min_confidence - 1 + 1e-12);
  }
  EXPECT_GT(accepted, 100) << "or nothing was tested";
}

TEST(ViewVerdict, ConfidenceNeverFallsWithBetterEvidence) {
  const auto improvements = {
      +[](ViewEvidence& e) { e.score += 10; },
      +[](ViewEvidence& e) { e.runner_up -= 10; },
      +[](ViewEvidence& e) { e.standing.score += 10; },
      +[](ViewEvidence& e) { e.sides[0].score += 10; },
      +[](ViewEvidence& e) { e.sides[1].score += 10; },
      +[](ViewEvidence& e) { e.known_share += 0.05; },
  };
  Random random(6);
  for (int i = 0; i < 2000; ++i) {
    const ViewEvidence worse = randomView(random);
    for (const auto& improve : improvements) {
      ViewEvidence better = worse;
      improve(better);
      EXPECT_GE(judgeView(better).confidence, judgeView(worse).confidence);
    }
  }
}

TEST(ViewVerdict, ALayoutWhoseHousesContradictIsRefused) {
  ViewEvidence e = goodView();
  e.standing.score = -20;
  const Verdict v = judgeView(e);
  EXPECT_EQ(v.status, Status::rejected) << "roads alone repeat between towns";
  EXPECT_LT(v.confidence, 0.5);
  e.standing.score = 30;
  EXPECT_LT(judgeView(e).confidence, judgeView(goodView()).confidence);
}

TEST(ViewVerdict, AStreetThatFitsOnOneSideOnlyIsRefused) {
  ViewEvidence e = goodView();
  e.sides[1].score = -10;
  EXPECT_EQ(judgeView(e).status, Status::rejected);
  EXPECT_LT(judgeView(e).confidence, 0.5);
  e.sides[1] = {};
  EXPECT_EQ(judgeView(e).status, Status::accepted) << "a view to one side is judged by that side";
}

TEST(ViewVerdict, MoreWindowsNeedMoreByTheRootOfTheirNumber) {
  ViewEvidence e = goodView();
  const double needed = neededMargin(e, kOptions);
  e.windows = 4;
  EXPECT_NEAR(neededMargin(e, kOptions), 2 * needed, 1e-9);
}

TEST(ViewVerdict, TheNeededMarginIsWhereAcceptanceBegins) {
  Random random(8);
  int judged = 0;
  for (int i = 0; i < 5000; ++i) {
    ViewEvidence e = randomView(random);
    const double share = e.score / e.expected, needed = neededMargin(e, kOptions);
    EXPECT_TRUE(std::isfinite(needed));
    if (!(e.expected > 0) || share < kOptions.min_agreement ||
        e.known_share < kOptions.min_known_share)
      continue;
    if (e.standing.score < 0 || e.sides[0].score < 0 || e.sides[1].score < 0) continue;
    ++judged;
    e.runner_up = e.score - needed * 1.001;
    EXPECT_EQ(judgeView(e).status, Status::accepted);
    e.runner_up = e.score - needed * 0.999;
    EXPECT_NE(judgeView(e).status, Status::accepted);
  }
  EXPECT_GT(judged, 100);
}

TEST(ViewVerdict, AViewWithoutAnythingUprightIsJudgedByTheRest) {
  ViewEvidence e = goodView();
  e.standing = {};
  e.sides = {};
  EXPECT_EQ(judgeView(e).status, Status::accepted);
}

TEST(ViewVerdict, NeedsMoreWhereWrongPlacesScoreVeryDifferently) {
  ViewEvidence e = goodView();
  e.score = 130;
  e.expected = 130;
  const double usual = expectedFalseAlarms(e, kOptions);
  e.wrong_scores = {60, 40, 10, -20, -40, -60, -80, -100, -120};
  EXPECT_GT(expectedFalseAlarms(e, kOptions), 10 * usual);
}

TEST(ViewVerdict, NeedsMoreFromTheAir) {
  ViewEvidence e = goodView();
  e.score = 115;
  e.expected = 115;
  EXPECT_EQ(judgeView(e).status, Status::accepted);
  e.from_the_air = true;
  EXPECT_NE(judgeView(e).status, Status::accepted);
}

TEST(ViewVerdict, TwoPlacesThatFitEquallyWellAreAmbiguous) {
  ViewEvidence e = goodView();
  e.runner_up = 290;
  const Verdict v = judgeView(e);
  EXPECT_EQ(v.status, Status::ambiguous) << v.reason;
  EXPECT_LT(v.confidence, 0.5);
  e.standing.score = -100;
  e.score = 100;
  e.runner_up = 99;
  EXPECT_EQ(judgeView(e).status, Status::rejected) << "both fit badly";
}

TEST(ViewVerdict, WithoutEvidenceIsRejected) {
  EXPECT_EQ(judgeView({}).status, Status::rejected);
  EXPECT_EQ(judgeView({}).confidence, 0);
  ViewEvidence no_number = goodView();
  no_number.score = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(judgeView(no_number).status, Status::rejected);
  EXPECT_EQ(judgeView(no_number).confidence, 0);
  ViewEvidence outside = goodView();
  outside.known_share = 0.1;
  const Verdict v = judgeView(outside);
  EXPECT_EQ(v.status, Status::rejected);
  EXPECT_NE(v.reason.find("10 %"), std::string::npos) << v.reason;
  ViewEvidence worse_than_chance = goodView();
  worse_than_chance.score = -50;
  worse_than_chance.runner_up = -800;
  EXPECT_EQ(judgeView(worse_than_chance).status, Status::rejected);
}

TEST(TailScale, IsTheScaleOfAnExponentialTail) {
  Random random(7);
  for (const double scale : {3.0, 20.0}) {
    double mean = 0;
    constexpr int kRuns = 2000;
    for (int run = 0; run < kRuns; ++run) {
      std::vector<double> scores;
      for (int i = 0; i < 40; ++i) scores.push_back(15 - scale * std::log(1 - random.uniform()));
      std::sort(scores.rbegin(), scores.rend());
      mean += tailScale(scores) / kRuns;
    }
    EXPECT_NEAR(mean, scale, 0.05 * scale);
  }
}

TEST(TailScale, OfTooFewScoresIsUnknown) {
  EXPECT_EQ(tailScale({}), 0);
  EXPECT_EQ(tailScale({50, 40, 30}), 0);
  EXPECT_GT(tailScale({50, 40, 30, 20}), 0);
}

TEST(ConsensusVerdict, GoodEvidenceIsAccepted) {
  const Verdict v = judge(goodConsensus(), kOptions);
  EXPECT_EQ(v.status, Status::accepted);
  EXPECT_GT(v.confidence, 0.7);
}

TEST(ConsensusVerdict, NothingIsAcceptedBelowAnyOfItsNeeds) {
  Random random(4);
  int accepted = 0;
  for (int i = 0; i < 20000; ++i) {
    ConsensusEvidence e;
    e.vertices = 60;
    e.inliers = static_cast<int>(random.below(60));
    e.runner_up = static_cast<int>(random.below(40));
    e.chance_inliers = random.uniform(0, 15);
    const Verdict v = judge(e, kOptions);
    EXPECT_EQ(v.status == Status::accepted, v.confidence >= 0.5);
    if (v.status != Status::accepted) continue;
    ++accepted;
    EXPECT_GE(e.inliers, kOptions.min_inliers);
    EXPECT_GE(e.inliers, kOptions.min_inlier_ratio * e.runner_up);
    EXPECT_GT(e.inliers, e.chance_inliers);
  }
  EXPECT_GT(accepted, 100);
}

TEST(ConsensusVerdict, ConfidenceGrowsWithInliersAndFallsWithTheRunnerUp) {
  double before = -1;
  for (int inliers = 0; inliers <= 40; ++inliers) {
    ConsensusEvidence e = goodConsensus();
    e.inliers = inliers;
    const double confidence = judge(e, kOptions).confidence;
    EXPECT_GE(confidence, before);
    before = confidence;
  }
  before = 2;
  for (int runner_up = 0; runner_up <= 25; ++runner_up) {
    ConsensusEvidence e = goodConsensus();
    e.runner_up = runner_up;
    const double confidence = judge(e, kOptions).confidence;
    EXPECT_LE(confidence, before);
    before = confidence;
  }
}

TEST(ConsensusVerdict, TwoEqualPlacesAreAmbiguousAndTwoBadOnesRejected) {
  ConsensusEvidence e = goodConsensus();
  e.runner_up = 24;
  EXPECT_EQ(judge(e, kOptions).status, Status::ambiguous);
  e.inliers = 5;
  e.runner_up = 5;
  EXPECT_EQ(judge(e, kOptions).status, Status::rejected);
  EXPECT_EQ(judge(ConsensusEvidence(), kOptions).status, Status::rejected);
}

}  // namespace
}  // namespace xview
