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
  return e;
}

TEST(ObjectVerdict, GoodEvidenceIsAcceptedWithConfidence) {
  const Verdict v = judge(goodPlace(), kOptions);
  EXPECT_EQ(v.status, Status::accepted);
  EXPECT_GT(v.confidence, 0.99);
}

TEST(ObjectVerdict, NothingIsAcceptedBelowAnyOfItsNeeds) {
  Random random(1);
  int accepted = 0;
  for (int i = 0; i < 20000; ++i) {
    const ObjectEvidence e = randomPlace(random);
    if (judge(e, kOptions).status != Status::accepted) continue;
    ++accepted;
    EXPECT_LE(falseAlarms(e), kOptions.max_false_alarms);
    EXPECT_GE((e.score - std::max(0.0, e.runner_up)) / std::sqrt(std::max(1, e.vertices) / 60.0),
              kOptions.min_margin - 1e-9);
    EXPECT_GE(e.score, kOptions.min_agreement * e.expected);
    EXPECT_GT(e.expected, 0);
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
  e.vertices = 240;
  EXPECT_GT(falseAlarms(e), falseAlarms(goodPlace()));
  EXPECT_NE(judge(e, kOptions).status, Status::accepted);
  e.score = 2 * (goodPlace().score - 7) + 7;
  EXPECT_DOUBLE_EQ(falseAlarms(e), falseAlarms(goodPlace()));
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

TEST(ObjectVerdict, WithoutEvidenceIsRejected) {
  EXPECT_EQ(judge(ObjectEvidence{}, kOptions).status, Status::rejected);
  EXPECT_EQ(judge(ObjectEvidence{}, kOptions).confidence, 0);
  ObjectEvidence no_number = goodPlace();
  no_number.score = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(judge(no_number, kOptions).status, Status::rejected);
  EXPECT_EQ(judge(no_number, kOptions).confidence, 0);
  ObjectEvidence negative = goodPlace();
  negative.score = -5;
  negative.runner_up = -100;
  negative.typical_wrong = -200;
  EXPECT_EQ(judge(negative, kOptions).status, Status::rejected)
      << "far ahead of the others, but worse than chance";
}

}  // namespace
}  // namespace xview
