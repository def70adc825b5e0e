// SPDX-License-Identifier: BSD-3-Clause
#include "xview/sequence.h"

#include <gtest/gtest.h>

#include "base/pose.h"
#include "localizer/simulated_drive.h"
#include "localizer/two_streets.h"
#include "verdict/verdict.h"
#include "xview/base/error.h"

namespace xview {
namespace {

/// Along a street that shows little lengthwise a pose may slip, but not as far as another place.
constexpr double kSlip_m = 3;

using test::BevTown;
using test::errorOf;
using test::mapOf;
using test::queryAt;
using test::simulatedDrive;
using test::twoStreets;

Options quiet() {
  Options options;
  options.threads = 1;
  return options;
}

const Eigen::Isometry3d kOdometry = poseFromYaw({310, -40, 5}, 2.3);

TEST(Sequence, HistoryTellsTwoEqualStreetsApart) {
  const BevTown town = twoStreets(false);
  const map::SemanticMap map = mapOf(town);
  const Localizer localizer(map, quiet());
  Sequence sequence(localizer, quiet());
  int ambiguous_alone = 0;
  std::size_t frame = 0;
  for (double x = -120; x <= 120; x += 40, frame += 10) {
    const SequenceAnswer answer = sequence.add(queryAt(town, x, 0, kOdometry), frame, frame + 10);
    EXPECT_TRUE(answer.fix.accepted()) << "at " << x << ": " << answer.fix.reason;
    EXPECT_LT(errorOf(answer.fix, x, 0), 0.5) << "at " << x;
    ambiguous_alone += answer.alone.status == Status::ambiguous;
  }
  EXPECT_GE(ambiguous_alone, 2);
}

TEST(Sequence, PointsAreComparedWithTheNextPlaceToo) {
  const BevTown town = twoStreets(false);
  const map::SemanticMap map = mapOf(town);
  const Localizer localizer(map, quiet());
  Sequence sequence(localizer, quiet());
  sequence.add(queryAt(town, 0, 0, kOdometry), 0, 10);
  const SequenceAnswer answer = sequence.add(queryAt(town, 40, 0, kOdometry), 10, 20);
  ASSERT_EQ(answer.windows, 2);
  ASSERT_LT(answer.runner_up, verdict::kAboutAsWell * answer.score)
      << "the score alone says little";
  // A place that fits and that nobody looked at closely would leave all of the margin that counts.
  EXPECT_LT(answer.fix.statistics.dense_margin, 10) << "half of what was seen is a copy";
}

TEST(Sequence, AllWindowsThatCountTellHowCloselyTheirPointsFit) {
  const auto& drive = simulatedDrive();
  const Localizer localizer(drive.map, quiet());
  Sequence sequence(localizer, quiet());
  double agreement = 0, null_inlier_ratio = 0, missing = 0;
  for (const std::size_t first : {0, 12, 24}) {
    const SequenceAnswer answer =
        sequence.add(drive.query("rear", first, first + 12), first, first + 12);
    const DenseEvidence &alone = answer.alone.statistics.dense,
                        &together = answer.fix.statistics.dense;
    ASSERT_TRUE(answer.alone.accepted() && alone.miss_ratio);
    agreement += alone.inlier_ratio;
    null_inlier_ratio += alone.null_inlier_ratio;
    missing += *alone.miss_ratio;
    EXPECT_NEAR(together.inlier_ratio, agreement / answer.windows, 1e-9);
    EXPECT_NEAR(together.null_inlier_ratio, null_inlier_ratio / answer.windows, 1e-9);
    EXPECT_NEAR(together.miss_ratio.value_or(-1), missing / answer.windows, 1e-9);
  }
}

TEST(Sequence, HistoryAcceptsNothingOutsideOfThePrior) {
  const BevTown town = twoStreets(false);
  const map::SemanticMap map = mapOf(town);
  Options options = quiet();
  options.prior.near = "-80,0,50";
  const Localizer localizer(map, options);
  Sequence sequence(localizer, options);
  std::size_t frame = 0;
  for (double x = -120; x <= 80; x += 40, frame += 10) {
    const SequenceAnswer answer = sequence.add(queryAt(town, x, 0, kOdometry), frame, frame + 10);
    EXPECT_EQ(answer.fix.accepted(), x < -30) << "at " << x << ": " << answer.fix.reason;
  }
}

TEST(Sequence, AWorldThatRepeatsAltogetherStaysAmbiguous) {
  const BevTown town = twoStreets(true);
  const map::SemanticMap map = mapOf(town);
  const Localizer localizer(map, quiet());
  Sequence sequence(localizer, quiet());
  std::size_t frame = 0;
  for (double x = -120; x <= 120; x += 40, frame += 10) {
    const SequenceAnswer answer = sequence.add(queryAt(town, x, 0, kOdometry), frame, frame + 10);
    EXPECT_EQ(answer.fix.status, Status::ambiguous) << "at " << x << ": " << answer.fix.reason;
  }
}

TEST(Sequence, NothingIsAcceptedOfAnotherTown) {
  const auto& drive = simulatedDrive();
  const Localizer localizer(drive.map, quiet());
  Sequence sequence(localizer, quiet());
  for (std::size_t first = 0; first + 10 <= drive.frames.at("elsewhere").size(); first += 10) {
    const SequenceAnswer answer =
        sequence.add(drive.query("elsewhere", first, first + 10), first, first + 10);
    EXPECT_FALSE(answer.fix.accepted()) << "from " << first << ": " << answer.fix.reason;
  }
}

TEST(Sequence, WhatFitsByItsNewestWindowOnlyIsNotAccepted) {
  const BevTown town = twoStreets(false);
  const map::SemanticMap map = mapOf(town);
  BevTown other;  // that led to a copy of a piece of the map
  Random random(9);
  other.street(-150, 0, 0, random);
  const Localizer localizer(map, quiet());
  Sequence sequence(localizer, quiet());
  sequence.add(queryAt(other, -120, 0, kOdometry), 0, 10);
  sequence.add(queryAt(other, -80, 0, kOdometry), 10, 20);
  const SequenceAnswer answer = sequence.add(queryAt(town, -40, 0, kOdometry), 20, 30);
  ASSERT_TRUE(answer.alone.accepted()) << answer.alone.reason;
  EXPECT_FALSE(answer.fix.accepted());
  EXPECT_LT(answer.fix.confidence, 0.5);
  EXPECT_NE(answer.fix.reason.find("by itself it would be accepted"), std::string::npos)
      << answer.fix.reason;
}

TEST(Sequence, AJumpOfTheOdometryDropsTheHistory) {
  const BevTown town = twoStreets(false);
  const map::SemanticMap map = mapOf(town);
  const Localizer localizer(map, quiet());
  Sequence sequence(localizer, quiet());
  sequence.add(queryAt(town, -120, 0, kOdometry), 0, 10);
  sequence.add(queryAt(town, -80, 0, kOdometry), 10, 20);
  // Carried to the other street, while the odometry says that it went on.
  const Eigen::Isometry3d T_jump = poseFromYaw({70, 200, 0}, 0.0) * kOdometry;
  const SequenceAnswer answer = sequence.add(queryAt(town, -40, 200, T_jump), 20, 30);
  EXPECT_TRUE(answer.restarted);
  EXPECT_TRUE(answer.fix.accepted()) << answer.fix.reason;
  EXPECT_LT(errorOf(answer.fix, -40, 200), 0.5);
  EXPECT_EQ(answer.windows, 1);
}

TEST(Sequence, WindowsThatShareFramesCountOnce) {
  const BevTown town = twoStreets(false);
  const map::SemanticMap map = mapOf(town);
  const Localizer localizer(map, quiet());
  Sequence sequence(localizer, quiet());
  const SequenceAnswer first = sequence.add(queryAt(town, -100, 0, kOdometry), 0, 10);
  const SequenceAnswer again = sequence.add(queryAt(town, -100, 0, kOdometry), 5, 15);
  EXPECT_EQ(again.windows, 1);
  EXPECT_NEAR(again.score, first.score, 1e-6);
  EXPECT_EQ(sequence.add(queryAt(town, -60, 0, kOdometry), 10, 20).windows, 2);
}

TEST(Sequence, WhatIsAcceptedAloneIsAcceptedWithItsHistory) {
  const auto& drive = simulatedDrive();
  const Localizer localizer(drive.map, quiet());
  Sequence sequence(localizer, quiet());
  for (std::size_t first = 0; first + 12 <= drive.frames.at("rear").size(); first += 12) {
    const SequenceAnswer answer =
        sequence.add(drive.query("rear", first, first + 12), first, first + 12);
    const Eigen::Isometry3d truth = drive.sessions.at("rear")->truth(first + 11);
    if (answer.alone.accepted()) {
      EXPECT_TRUE(answer.fix.accepted()) << answer.fix.reason;
    }
    if (answer.fix.accepted()) {
      EXPECT_LT((answer.fix.T_map_sensor.translation() - truth.translation()).norm(), kSlip_m)
          << "from " << first;
    }
    EXPECT_EQ(answer.fix.timing_ms.back().first, "total");
  }
}

TEST(Sequence, ThreadsDoNotChangeTheAnswer) {
  const BevTown town = twoStreets(false);
  const map::SemanticMap map = mapOf(town);
  std::vector<double> scores;
  for (const int threads : {1, 2}) {
    Options options;
    options.threads = threads;
    const Localizer localizer(map, options);
    Sequence sequence(localizer, options);
    sequence.add(queryAt(town, 20, 0, kOdometry), 0, 10);
    const SequenceAnswer answer = sequence.add(queryAt(town, 60, 0, kOdometry), 10, 20);
    scores.push_back(answer.score);
    scores.push_back(answer.runner_up);
    scores.push_back(answer.fix.T_map_query.matrix().sum());
  }
  EXPECT_TRUE(std::equal(scores.begin(), scores.begin() + 3, scores.begin() + 3));
}

TEST(Sequence, AnEmptyQueryIsRejectedAndHarmsNothing) {
  const BevTown town = twoStreets(false);
  const map::SemanticMap map = mapOf(town);
  const Localizer localizer(map, quiet());
  Sequence sequence(localizer, quiet());
  Query nothing;
  nothing.poses = {kOdometry};
  EXPECT_FALSE(sequence.add(nothing, 0, 10).fix.accepted());
  sequence.add(queryAt(town, -100, 0, kOdometry), 10, 20);
  EXPECT_FALSE(sequence.add(nothing, 20, 30).fix.accepted());
  EXPECT_TRUE(sequence.add(queryAt(town, -60, 0, kOdometry), 30, 40).fix.accepted());
}

TEST(Sequence, WalksHaveNothingToSum) {
  Options options;
  options.method = "walks";
  const map::SemanticMap map;
  const Localizer localizer(map, options);
  EXPECT_THROW(Sequence(localizer, options), UsageError);
}

}  // namespace
}  // namespace xview
