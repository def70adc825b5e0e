// SPDX-License-Identifier: BSD-3-Clause
#include "eval/evaluation.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "base/random.h"

namespace xview {
namespace {

TEST(Quantile, IsTheMiddleValueOfAnOddNumber) { EXPECT_DOUBLE_EQ(quantile({9, 1, 4}, 0.5), 4); }
TEST(Quantile, IsLinearBetweenNeighbours) { EXPECT_DOUBLE_EQ(quantile({0, 10}, 0.9), 9); }
TEST(Quantile, EndsAreTheExtremes) {
  EXPECT_DOUBLE_EQ(quantile({3, 7, 5}, 0), 3);
  EXPECT_DOUBLE_EQ(quantile({3, 7, 5}, 1), 7);
}
TEST(Quantile, OfNothingIsUnknown) { EXPECT_TRUE(std::isnan(quantile({}, 0.5))); }

TEST(ShareWithin, CountsTheLimitItself) { EXPECT_DOUBLE_EQ(shareWithin({1, 2, 3}, 2, 4), 0.5); }
TEST(ShareWithin, NeverCountsWhatHasNoValue) {
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_DOUBLE_EQ(shareWithin({inf, std::nan(""), 1}, 1e300, 4), 0.25);
}
TEST(ShareWithin, OfNoQueriesIsUnknown) { EXPECT_TRUE(std::isnan(shareWithin({}, 1, 0))); }

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

TEST(RecallAtPrecision, IsTheLargestOfThePointsThatAreThatPrecise) {
  const std::vector<PrecisionRecall> curve{{0.9, 1, 0.2}, {0.8, 0.98, 0.3}, {0.7, 0.99, 0.6}};
  EXPECT_DOUBLE_EQ(recallAtPrecision(curve, 0.99), 0.6);
  EXPECT_DOUBLE_EQ(recallAtPrecision(curve, 0.999), 0.2);
  EXPECT_DOUBLE_EQ(recallAtPrecision({{0.9, 0.5, 0.2}}, 0.99), 0);
}

TEST(ConfidenceBands, HoldEveryAnswerOnce) {
  const auto bands = confidenceBands({{1, true}, {0.999, false}, {0.98, true}, {0, false}});
  std::size_t answers = 0, right = 0;
  for (const ConfidenceBand& band : bands) {
    answers += band.answers;
    right += band.right;
  }
  EXPECT_EQ(answers, 4u);
  EXPECT_EQ(right, 2u);
  EXPECT_EQ(bands.back().answers, 2u);
  EXPECT_DOUBLE_EQ(bands.back().mean_confidence, 0.9995);
  EXPECT_TRUE(std::isnan(bands[1].mean_confidence));
}

TEST(ErrorSummary, IsThatOfNumbersByHand) {
  const ErrorSummary e = summarized({3, 4, 5});
  EXPECT_DOUBLE_EQ(e.rmse, std::sqrt(50.0 / 3));
  EXPECT_DOUBLE_EQ(e.mean, 4);
  EXPECT_NEAR(e.deviation, std::sqrt(2.0 / 3), 1e-12);
  EXPECT_DOUBLE_EQ(e.median, 4);
  EXPECT_DOUBLE_EQ(e.p90, 4.8);
  EXPECT_DOUBLE_EQ(e.max, 5);
  EXPECT_TRUE(std::isnan(summarized({}).rmse));
}

using Vector6d = Eigen::Matrix<double, 6, 1>;

/// Small against a radian, correlated, and with axes of different length.
Matrix6d someCovariance() {
  Vector6d sigma;
  sigma << 0.3, 0.1, 0.05, 0.002, 0.004, 0.01;
  Matrix6d correlation = Matrix6d::Identity();
  correlation(0, 5) = correlation(5, 0) = 0.8;
  correlation(1, 2) = correlation(2, 1) = -0.5;
  return sigma.asDiagonal() * correlation * sigma.asDiagonal();
}

Eigen::Isometry3d somePose() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = Eigen::Vector3d(40, -30, 2);
  T.linear() =
      Eigen::AngleAxisd(2.5, Eigen::Vector3d(0.1, -0.2, 1).normalized()).toRotationMatrix();
  return T;
}

Eigen::Isometry3d moved(Eigen::Isometry3d T, const Vector6d& left_increment) {
  const Eigen::Vector3d turn = left_increment.tail<3>();
  T.translation() += left_increment.head<3>();
  if (turn.norm() > 0) T.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * T.linear();
  return T;
}

std::vector<double> sampled(const Matrix6d& drawn_from, const Matrix6d& claimed) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const Matrix6d L = drawn_from.llt().matrixL();
  std::vector<double> values;
  for (int i = 0; i < 20000; ++i) {
    const Vector6d unit = Vector6d::NullaryExpr([&](Eigen::Index) { return normal(random); });
    values.push_back(normalisedErrorSquared(claimed, moved(somePose(), L * unit), somePose()));
  }
  return values;
}

TEST(NormalisedErrorSquared, OfSamplesFromTheCovarianceIsChiSquareOfSix) {
  const Consistency c = consistencyOf(sampled(someCovariance(), someCovariance()));
  EXPECT_EQ(c.answers, 20000u);
  EXPECT_NEAR(c.mean, 1, 0.02);
  EXPECT_NEAR(c.median, 0.891, 0.02);
  EXPECT_NEAR(c.within_3_sigma, 0.9973, 0.0015);
}

TEST(NormalisedErrorSquared, OfACovarianceTwiceTooWideIsHalf) {
  EXPECT_NEAR(consistencyOf(sampled(someCovariance(), 2 * someCovariance())).mean, 0.5, 0.01);
}

TEST(NormalisedErrorSquared, CountsEachAxisInItsOwnSigma) {
  Vector6d sigma;
  sigma << 1, 2, 3, 0.01, 0.02, 0.03;
  const Matrix6d covariance = sigma.cwiseAbs2().asDiagonal();
  for (int axis = 0; axis < 6; ++axis) {
    const Vector6d step = 2 * sigma(axis) * Vector6d::Unit(axis);
    EXPECT_NEAR(normalisedErrorSquared(covariance, moved(somePose(), step), somePose()), 4, 1e-6)
        << axis;
  }
}

TEST(NormalisedErrorSquared, IsZeroAtTheTruth) {
  EXPECT_NEAR(normalisedErrorSquared(someCovariance(), somePose(), somePose()), 0, 1e-9);
}

TEST(NormalisedErrorSquared, WithoutACovarianceIsInfinite) {
  EXPECT_TRUE(std::isinf(normalisedErrorSquared(Matrix6d::Zero(), somePose(), somePose())));
  EXPECT_TRUE(std::isinf(normalisedErrorSquared(-someCovariance(), somePose(), somePose())));
}

TEST(Consistency, CountsTheLimitOfThreeSigmaItself) {
  const Consistency c = consistencyOf({kThreeSigmaOfSix, 2 * kThreeSigmaOfSix, 6, 0});
  EXPECT_DOUBLE_EQ(c.within_3_sigma, 0.75);
  EXPECT_DOUBLE_EQ(c.mean, (3 * kThreeSigmaOfSix + 6) / 24);
}

TEST(Consistency, OfNoAnswerIsUnknown) {
  const Consistency c = consistencyOf({});
  EXPECT_EQ(c.answers, 0u);
  EXPECT_TRUE(std::isnan(c.mean) && std::isnan(c.median) && std::isnan(c.within_3_sigma));
}

ScoredQuery query(Status status, double confidence, double error_m, double yaw_rad = 0) {
  ScoredQuery q;
  q.input = "town/rear";
  q.fix.status = status;
  q.fix.confidence = confidence;
  q.fix.hypotheses.resize(1);
  q.truth.translation() = Eigen::Vector3d(5, -3, 2);
  q.fix.T_map_sensor = q.truth * Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ());
  q.fix.T_map_sensor.translation().y() += error_m;
  q.fix.timing_ms = {{"read", 4}, {"total", 10}};
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
  EXPECT_NEAR(e.best.ape_deg.median, 1.7189, 1e-3);
}

TEST(Evaluation, PrecisionAndRecallAreThoseOfTheVerdict) {
  const auto e = evaluate({query(Status::accepted, 0.9, 0.1), query(Status::accepted, 0.8, 50),
                           query(Status::ambiguous, 0.4, 0.2), query(Status::rejected, 0.1, 90)},
                          5);
  EXPECT_DOUBLE_EQ(e.precision, 0.5);
  EXPECT_DOUBLE_EQ(e.recall, 0.25);
  EXPECT_DOUBLE_EQ(e.f1, 1.0 / 3) << "the harmonic mean";
  EXPECT_EQ(e.accepted, 2u);
  EXPECT_EQ(e.ambiguous, 1u);
  EXPECT_EQ(e.rejected, 1u);
}

TEST(Evaluation, WithoutAnyHitTheHarmonicMeanIsZero) {
  EXPECT_DOUBLE_EQ(evaluate({query(Status::accepted, 0.9, 50)}, 5).f1, 0);
}

TEST(Evaluation, JudgesTheCovarianceOfRightAcceptedAnswersOnly) {
  ScoredQuery right = query(Status::accepted, 0.9, 0.2);
  right.fix.covariance = 0.01 * Matrix6d::Identity();  // 0.2 m are two sigma
  ScoredQuery wrong = right, refused = right;
  wrong.fix.T_map_sensor.translation().x() += 50;
  refused.fix.status = Status::rejected;
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
  EXPECT_DOUBLE_EQ(e.false_accept_rate, 0.5);
  EXPECT_EQ(e.negatives, 2u);
  EXPECT_DOUBLE_EQ(e.precision, 0.5);
  EXPECT_DOUBLE_EQ(e.recall, 1);
  EXPECT_DOUBLE_EQ(e.area_under_pr, 0.5);
}

TEST(Evaluation, AQueryWithoutPoseIsNeverASuccess) {
  ScoredQuery lost = query(Status::rejected, 0, 0);
  lost.fix.hypotheses.clear();
  const auto e = evaluate({lost}, 5);
  EXPECT_DOUBLE_EQ(e.best.within_m.back(), 0);
  EXPECT_DOUBLE_EQ(e.recall, 0);
  EXPECT_TRUE(std::isnan(e.best.ape_m.median));
}

TEST(Evaluation, TimesAreMediansPerStageAndInTotal) {
  ScoredQuery slow = query(Status::accepted, 1, 0);
  slow.fix.timing_ms = {{"read", 8}, {"refine", 3}, {"total", 30}};
  const auto e = evaluate({query(Status::accepted, 1, 0), slow}, 5);
  EXPECT_DOUBLE_EQ(e.total_ms.median, 20);
  ASSERT_EQ(e.stages.size(), 3u);
  EXPECT_EQ(e.stages[0].name, "read");
  EXPECT_DOUBLE_EQ(e.stages[0].ms.median, 6);
  EXPECT_DOUBLE_EQ(e.stages[0].ms.mean, 6);
  EXPECT_DOUBLE_EQ(e.stages[0].ms.deviation, 2);
  EXPECT_EQ(e.stages[1].name, "refine");
  EXPECT_DOUBLE_EQ(e.stages[1].ms.deviation, 0);
  EXPECT_EQ(e.stages[2].name, "total");
  EXPECT_NE(evaluationTable(e).find("\nread                   6.0       6.0        2.0\n"),
            std::string::npos)
      << evaluationTable(e);
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
      successCsv(evaluate({query(Status::accepted, 1, 0.25), query(Status::rejected, 1, 2.0)}, 5));
  EXPECT_NE(csv.find("\n0.2,0,0\n0.3,0.5,0.5\n"), std::string::npos);
  EXPECT_NE(csv.find("\n30.0,1,0.5\n"), std::string::npos);
}

}  // namespace
}  // namespace xview
