// SPDX-License-Identifier: BSD-3-Clause
#include "xview/verify/verdict.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "xview/types/random.h"

namespace xview {
namespace {

const VerdictOptions kOptions;

Verdict judgePlace(const PlaceEvidence& e) { return judge(e, kOptions.min_margin, kOptions); }

PlaceEvidence goodPlace() {
  PlaceEvidence e;
  e.score = 900;
  e.runner_up = 300;
  e.expected = 1000;
  e.known_share = 0.95;
  e.places = 5;
  return e;
}

PlaceEvidence randomPlace(Random& random) {
  PlaceEvidence e;
  e.score = random.uniform(-200, 1000);
  e.runner_up = random.uniform(-200, 1000);
  e.expected = random.uniform(-100, 1500);
  e.known_share = random.uniform();
  e.places = static_cast<int>(random.below(6));
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
  EXPECT_EQ(judgePlace(negative).status, Status::rejected) << "far ahead of the others, but worse than chance";
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
