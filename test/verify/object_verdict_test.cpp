// SPDX-License-Identifier: BSD-3-Clause
#include "xview/verify/object_verdict.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "xview/types/random.h"

namespace xview {
namespace {

const ObjectVerdictOptions kOptions;

ObjectEvidence goodPlace() {
  ObjectEvidence e;
  e.score = 55;
  e.runner_up = 15;
  e.typical_wrong = -5;
  e.wrong_deviation = 6;
  e.wrong_places = 59;
  e.expected = 70;
  e.known_share = 0.9;
  e.vertices = 60;
  e.inliers = 30;
  return e;
}

ObjectEvidence randomPlace(Random& random) {
  ObjectEvidence e;
  e.score = random.uniform(-50, 150);
  e.runner_up = random.uniform(-50, e.score);
  e.typical_wrong = random.uniform(-80, e.runner_up);
  e.wrong_deviation = random.uniform(0, 20);
  e.wrong_places = static_cast<int>(random.below(60));
  e.expected = random.uniform(-20, 150);
  e.known_share = random.uniform();
  e.vertices = static_cast<int>(random.below(300));
  e.inliers = static_cast<int>(random.below(40));
  return e;
}

TEST(ObjectVerdict, GoodEvidenceIsAcceptedWithConfidence) {
  const Verdict v = judge(goodPlace(), kOptions);
  EXPECT_EQ(v.status, Status::accepted);
  EXPECT_GT(v.confidence, 0.99);
}

TEST(ObjectVerdict, TwoOrThreeVerticesThatAgreeProveNothing) {
  ObjectEvidence e = goodPlace();
  e.inliers = 3;
  const Verdict v = judge(e, kOptions);
  EXPECT_EQ(v.status, Status::rejected);
  EXPECT_EQ(v.reason, "3 of 60 vertices agree, 4 needed");
  EXPECT_LT(v.confidence, judge(goodPlace(), kOptions).confidence);
  e.inliers = 4;
  EXPECT_EQ(judge(e, kOptions).status, Status::accepted);
}

TEST(ObjectVerdict, NothingIsAcceptedBelowAnyOfItsNeeds) {
  Random random(1);
  int accepted = 0;
  for (int i = 0; i < 20000; ++i) {
    const ObjectEvidence e = randomPlace(random);
    if (judge(e, kOptions).status != Status::accepted) continue;
    ++accepted;
    EXPECT_LE(falseAlarms(e), kOptions.max_false_alarms);
    const bool knows_wrong_places = e.wrong_places >= 10;
    const double runner_up = knows_wrong_places ? e.runner_up : std::max(0.0, e.runner_up);
    const double least = knows_wrong_places ? std::min(0.0, e.typical_wrong) : 0;
    EXPECT_GE((e.score - runner_up) / scoreSpread(e.vertices), kOptions.min_margin - 1e-9);
    EXPECT_GE(e.score - least, kOptions.min_agreement * (e.expected - least) - 1e-9);
    EXPECT_GT(e.expected, least);
    EXPECT_GE(e.known_share, kOptions.min_known_share);
  }
  EXPECT_GT(accepted, 100) << "or nothing was tested";
}

TEST(ObjectVerdict, ConfidenceIsAShareAndHighWhereAccepted) {
  Random random(2);
  for (int i = 0; i < 20000; ++i) {
    const Verdict v = judge(randomPlace(random), kOptions);
    EXPECT_GE(v.confidence, 0);
    EXPECT_LE(v.confidence, 1);
    if (v.status == Status::accepted) {
      EXPECT_GT(v.confidence, 0.97);
    }
  }
}

TEST(ObjectVerdict, ConfidenceNeverFallsWithTheScoreAndNeverGrowsWithWrongPlaces) {
  double before = -1, alarms_before = 2;
  for (double score = -20; score <= 120; score += 1) {
    ObjectEvidence e = goodPlace();
    e.score = score;
    EXPECT_GE(judge(e, kOptions).confidence, before);
    EXPECT_LE(falseAlarms(e), alarms_before);
    before = judge(e, kOptions).confidence;
    alarms_before = falseAlarms(e);
  }
  EXPECT_GT(before, 0.999);
  for (double typical = -50; typical <= 50; typical += 1) {
    ObjectEvidence e = goodPlace();
    e.typical_wrong = typical;
    EXPECT_LE(judge(e, kOptions).confidence, before);
    before = judge(e, kOptions).confidence;
  }
}

TEST(ObjectVerdict, ALargeQueryNeedsALargerLead) {
  ObjectEvidence e = goodPlace();
  e.vertices = 16 * goodPlace().vertices;
  const double scale = 4;
  EXPECT_NEAR(scoreSpread(e.vertices), scale * scoreSpread(goodPlace().vertices), 1e-12);
  EXPECT_GT(falseAlarms(e), falseAlarms(goodPlace()));
  e.score = 45;
  EXPECT_NE(judge(e, kOptions).status, Status::accepted);
  // All scores grow alike.
  for (double* nats : {&e.runner_up, &e.typical_wrong, &e.wrong_deviation, &e.expected})
    *nats *= scale;
  e.score = scale * goodPlace().score;
  EXPECT_NEAR(falseAlarms(e), falseAlarms(goodPlace()), 1e-9 * falseAlarms(goodPlace()));
}

TEST(ObjectVerdict, ATinyQueryNeedsNoLessThanASmallOne) {
  EXPECT_EQ(scoreSpread(0), scoreSpread(15));
  EXPECT_EQ(scoreSpread(4), scoreSpread(15));
  EXPECT_LT(scoreSpread(15), scoreSpread(16));
}

TEST(ObjectVerdict, TheSameLeadIsWorthLessFarBelowTheScoreOfATrueOne) {
  ObjectEvidence e = goodPlace();
  double before = 0;
  for (const double expected : {60.0, 90.0, 120.0, 180.0}) {
    e.expected = expected;
    EXPECT_GT(falseAlarms(e), before);
    before = falseAlarms(e);
  }
  e.expected = 50;
  const double reached = falseAlarms(e);
  e.expected = 20;
  EXPECT_EQ(falseAlarms(e), reached) << "more than a true place should score is no proof";
}

TEST(ObjectVerdict, WrongPlacesThatSpreadWidelyAskForALargerLead) {
  ObjectEvidence e = goodPlace();
  e.wrong_deviation = 20;
  EXPECT_GT(falseAlarms(e), 10 * falseAlarms(goodPlace()));
}

TEST(ObjectVerdict, TwoPlacesThatFitEquallyWellAreAmbiguous) {
  ObjectEvidence e = goodPlace();
  e.runner_up = 54;
  const Verdict v = judge(e, kOptions);
  EXPECT_EQ(v.status, Status::ambiguous) << v.reason;
  EXPECT_LT(v.confidence, 0.5);
}

TEST(ObjectVerdict, AFewWrongPlacesAreNotTakenForTypicalOnes) {
  ObjectEvidence e = goodPlace();
  e.wrong_places = 2;
  e.typical_wrong = -500;
  e.runner_up = 40;
  EXPECT_NE(judge(e, kOptions).status, Status::accepted);
  e.wrong_places = 0;
  e.runner_up = 0;
  EXPECT_EQ(judge(e, kOptions).status, Status::accepted) << "55 nats above unseen area";
}

TEST(ObjectVerdict, APlaceFarBelowTheScoreOfATrueOneIsRejected) {
  ObjectEvidence e = goodPlace();
  e.expected = 400;
  EXPECT_EQ(judge(e, kOptions).status, Status::rejected);
  e = goodPlace();
  e.known_share = 0.1;
  EXPECT_EQ(judge(e, kOptions).status, Status::rejected);
  EXPECT_NE(judge(e, kOptions).reason.find("10 %"), std::string::npos);
}

TEST(ObjectVerdict, OnlyTheDistanceToWrongPlacesCounts) {
  // Much of a noisy query has no partner even at the true place: its score may be below zero.
  ObjectEvidence e = goodPlace();
  for (double* score : {&e.score, &e.runner_up, &e.typical_wrong, &e.expected}) *score -= 60;
  EXPECT_EQ(judge(e, kOptions).status, Status::accepted);
  EXPECT_DOUBLE_EQ(falseAlarms(e), falseAlarms(goodPlace()));
  e.wrong_places = 3;
  EXPECT_EQ(judge(e, kOptions).status, Status::rejected) << "nothing to compare with but chance";
}

TEST(ObjectVerdict, WithoutEvidenceIsRejected) {
  EXPECT_EQ(judge(ObjectEvidence{}, kOptions).status, Status::rejected);
  EXPECT_EQ(judge(ObjectEvidence{}, kOptions).confidence, 0);
  ObjectEvidence no_number = goodPlace();
  no_number.score = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(judge(no_number, kOptions).status, Status::rejected);
  EXPECT_EQ(judge(no_number, kOptions).confidence, 0);
}

}  // namespace
}  // namespace xview
