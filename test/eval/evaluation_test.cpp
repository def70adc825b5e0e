// SPDX-License-Identifier: BSD-3-Clause
#include "xview/eval/evaluation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "xview/eval/report.h"

namespace xview {
namespace {

ScoredQuery query(Status status, double confidence, double error_m, double yaw_rad = 0) {
  ScoredQuery q;
  q.input = "town/rear";
  q.status = status;
  q.confidence = confidence;
  q.has_pose = true;
  q.truth.translation() = Eigen::Vector3d(5, -3, 2);
  q.estimate = q.truth * Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ());
  q.estimate.translation().y() += error_m;
  q.timing_ms = {{"read", 4}, {"total", 10}};
  return q;
}

ScoredQuery negative(Status status, double confidence) {
  ScoredQuery q = query(status, confidence, 0);
  q.negative = true;
  return q;
}

TEST(Evaluation, SuccessCountsTheBestHypothesisEvenIfItWasNotAccepted) {
  const auto e = evaluate({query(Status::accepted, 1, 0.1), query(Status::rejected, 0.1, 1.5)}, 5);
  EXPECT_DOUBLE_EQ(e.best.within_m[0], 0.5);  // 1 m
  EXPECT_DOUBLE_EQ(e.best.within_m[1], 1.0);  // 2 m
  EXPECT_DOUBLE_EQ(e.believed.within_m[1], 0.5);
}

TEST(Evaluation, AnglesAreJudgedInDegrees) {
  const auto e = evaluate({query(Status::accepted, 1, 0, 0.03)}, 5);  // 1.7 deg
  EXPECT_DOUBLE_EQ(e.best.within_deg[0], 0);
  EXPECT_DOUBLE_EQ(e.best.within_deg[1], 1);
  EXPECT_NEAR(e.best.median_deg, 1.7189, 1e-3);
}

TEST(Evaluation, PrecisionAndRecallAreThoseOfTheVerdict) {
  const auto e = evaluate({query(Status::accepted, 0.9, 0.1), query(Status::accepted, 0.8, 50),
                           query(Status::ambiguous, 0.4, 0.2), query(Status::rejected, 0.1, 90)},
                          5);
  EXPECT_DOUBLE_EQ(e.precision, 0.5);
  EXPECT_DOUBLE_EQ(e.recall, 0.25);
  EXPECT_EQ(e.accepted, 2u);
  EXPECT_EQ(e.ambiguous, 1u);
  EXPECT_EQ(e.rejected, 1u);
}

TEST(Evaluation, JudgesTheCovarianceOfRightAcceptedAnswersOnly) {
  ScoredQuery right = query(Status::accepted, 0.9, 0.2);
  right.has_covariance = true;
  right.covariance = 0.01 * Matrix6d::Identity();  // 0.2 m are two sigma
  ScoredQuery wrong = right, refused = right;
  wrong.estimate.translation().x() += 50;
  refused.status = Status::rejected;
  const auto e = evaluate({right, wrong, refused, query(Status::accepted, 0.8, 0.1)}, 5);
  EXPECT_EQ(e.consistency.answers, 1u);
  EXPECT_NEAR(e.consistency.mean, 4.0 / 6, 1e-9);
  EXPECT_DOUBLE_EQ(e.consistency.within_3_sigma, 1);
}

TEST(Evaluation, AcceptedNegativesLowerThePrecisionButNotTheRecall) {
  const auto e = evaluate({query(Status::accepted, 0.9, 0.1), negative(Status::accepted, 0.95),
                           negative(Status::rejected, 0.2)},
                          5);
  EXPECT_EQ(e.false_accepts, 1u);
  EXPECT_EQ(e.negatives, 2u);
  EXPECT_DOUBLE_EQ(e.precision, 0.5);
  EXPECT_DOUBLE_EQ(e.recall, 1);
  EXPECT_DOUBLE_EQ(e.area_under_pr, 0.5);
}

TEST(Evaluation, AQueryWithoutPoseIsNeverASuccess) {
  ScoredQuery lost = query(Status::rejected, 0, 0);
  lost.has_pose = false;
  const auto e = evaluate({lost}, 5);
  EXPECT_DOUBLE_EQ(e.best.within_m.back(), 0);
  EXPECT_DOUBLE_EQ(e.recall, 0);
  EXPECT_TRUE(std::isnan(e.best.median_m));
}

TEST(Evaluation, TimesAreMediansPerStageAndInTotal) {
  ScoredQuery slow = query(Status::accepted, 1, 0);
  slow.timing_ms = {{"read", 8}, {"refine", 3}, {"total", 30}};
  const auto e = evaluate({query(Status::accepted, 1, 0), slow}, 5);
  EXPECT_DOUBLE_EQ(e.median_ms, 20);
  ASSERT_EQ(e.stages_ms.size(), 2u);
  EXPECT_EQ(e.stages_ms[0], (std::pair<std::string, double>("read", 6)));
  EXPECT_EQ(e.stages_ms[1], (std::pair<std::string, double>("refine", 3)));
  EXPECT_NE(evaluationTable(e).find("read 6.0, refine 3.0\n"), std::string::npos);
}

TEST(Evaluation, OfNothingIsUnknownNotPerfect) {
  const auto e = evaluate({}, 5);
  EXPECT_TRUE(std::isnan(e.precision));
  EXPECT_TRUE(std::isnan(e.recall));
  EXPECT_NE(evaluationJson(e).find("\"precision\": null"), std::string::npos);
  EXPECT_EQ(evaluationTable(e).find("nan"), std::string::npos);
}

TEST(Report, CsvHasOneLinePerQueryAndQuotesPaths) {
  ScoredQuery q = query(Status::accepted, 1, 0.25);
  q.input = "a \"b\", c";
  const std::string csv = resultsCsv({q, negative(Status::rejected, 0)});
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 3);
  EXPECT_NE(csv.find("\"a \"\"b\"\", c\",0,0,0,accepted,1,0.250000"), std::string::npos);
}

TEST(Report, SuccessCurveReachesOneWhereTheLargestErrorIs) {
  const std::string csv =
      successCsv({query(Status::accepted, 1, 0.25), query(Status::rejected, 1, 2.0)});
  EXPECT_NE(csv.find("\n0.2,0,0\n0.3,0.5,0.5\n"), std::string::npos);
  EXPECT_NE(csv.find("\n30.0,1,0.5\n"), std::string::npos);
}

TEST(Report, PageNeedsNothingFromOutsideAndEscapesPaths) {
  ScoredQuery q = query(Status::accepted, 1, 0.25);
  q.input = "<script>alert(1)</script>";
  const std::string html = reportHtml(evaluate({q}, 5), {q}, {{1, 2, 3, 0xFF0000}});
  EXPECT_EQ(html.find("http"), std::string::npos);
  EXPECT_EQ(html.find("<script>alert"), std::string::npos);
  EXPECT_NE(html.find("'ff0000'"), std::string::npos);
}

}  // namespace
}  // namespace xview
