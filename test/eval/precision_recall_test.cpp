// SPDX-License-Identifier: BSD-3-Clause
#include "xview/eval/precision_recall.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "xview/types/random.h"

namespace xview {
namespace {

TEST(PrecisionRecall, PerfectRankingHasAreaOne) {
  const auto curve = precisionRecallCurve({{0.9, true}, {0.8, true}, {0.3, false}}, 2);
  EXPECT_DOUBLE_EQ(averagePrecision(curve), 1);
}

TEST(PrecisionRecall, KnownCurveByHand) {
  // believed in this order: right, wrong, right; 4 could have been right
  const auto curve = precisionRecallCurve({{0.5, true}, {0.9, true}, {0.7, false}}, 4);
  ASSERT_EQ(curve.size(), 3u);
  EXPECT_DOUBLE_EQ(curve[1].precision, 0.5);
  EXPECT_DOUBLE_EQ(curve[1].recall, 0.25);
  EXPECT_DOUBLE_EQ(curve[2].precision, 2.0 / 3);
  EXPECT_DOUBLE_EQ(averagePrecision(curve), 0.25 * 1 + 0.25 * 2 / 3);
}

TEST(PrecisionRecall, EquallySureAnswersAreOnePoint) {
  const auto curve = precisionRecallCurve({{0.5, true}, {0.5, false}}, 1);
  ASSERT_EQ(curve.size(), 1u);
  EXPECT_DOUBLE_EQ(curve[0].precision, 0.5);
}

TEST(PrecisionRecall, DoesNotDependOnTheOrderOfTheAnswers) {
  Random random(3);
  std::vector<Detection> detections;
  for (int i = 0; i < 40; ++i) detections.push_back({0.1 * random.below(10), random.below(2) == 1});
  const double area = averagePrecision(precisionRecallCurve(detections, 30));
  std::reverse(detections.begin(), detections.end());
  EXPECT_DOUBLE_EQ(averagePrecision(precisionRecallCurve(detections, 30)), area);
}

TEST(PrecisionRecall, RecallNeverFalls) {
  Random random(4);
  std::vector<Detection> detections;
  for (int i = 0; i < 50; ++i) detections.push_back({random.uniform(), random.below(2) == 1});
  const auto curve = precisionRecallCurve(detections, 50);
  EXPECT_TRUE(std::is_sorted(curve.begin(), curve.end(),
                             [](const auto& a, const auto& b) { return a.recall < b.recall; }));
}

TEST(PrecisionRecall, EmptyHasNoAreaAndNoPoints) {
  EXPECT_TRUE(precisionRecallCurve({}, 0).empty());
  EXPECT_DOUBLE_EQ(averagePrecision({}), 0);
}

TEST(F1, IsTheHarmonicMean) {
  EXPECT_DOUBLE_EQ(f1Score(1, 0.5), 2.0 / 3);
  EXPECT_DOUBLE_EQ(f1Score(0, 0), 0);
}

}  // namespace
}  // namespace xview
