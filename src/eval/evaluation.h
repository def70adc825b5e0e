// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "xview/base/localization.h"

namespace xview {

/// The q-quantile (0 = smallest, 0.5 = median, 1 = largest), linear between neighbours; NaN if
/// there are no values.
double quantile(std::vector<double> values, double q);

/// Share of `total` that has a value within the limit (inclusive); values that are not finite never
/// have. NaN if total is 0.
double shareWithin(const std::vector<double>& values, double limit, std::size_t total);

/// One answer as a detection: how sure the program was, and whether it was right.
struct Detection {
  double confidence = 0;
  bool correct = false;
};

/// Precision and recall if exactly the answers with at least this confidence are believed.
struct PrecisionRecall {
  double threshold = 0;
  double precision = 0;
  double recall = 0;
};

/// One point per distinct confidence, from the surest answer down. `positives` is the number of
/// answers that could have been correct; detections out of the map can only be wrong and do not
/// count there.
std::vector<PrecisionRecall> precisionRecallCurve(std::vector<Detection> detections,
                                                  std::size_t positives);

/// Area under the curve as average precision: sum of (R_k - R_k-1) P_k, without interpolation,
/// which would flatter.
double averagePrecision(const std::vector<PrecisionRecall>& curve);

/// The largest recall of the points of a curve with at least this precision; 0 if none has it.
double recallAtPrecision(const std::vector<PrecisionRecall>& curve, double precision);

/// Answers that are about equally sure, and how often they are right: a confidence is calibrated if
/// `right` over `answers` is its mean. The number of out-of-map queries matters, too.
struct ConfidenceBand {
  double low = 0, high = 0;  ///< confidence; `low` included, `high` only if it is 1
  std::size_t answers = 0, right = 0;
  double mean_confidence = 0;  ///< NaN without answers
};
std::vector<ConfidenceBand> confidenceBands(const std::vector<Detection>& detections);

/// What a number of errors comes to.
struct ErrorSummary {
  std::size_t count = 0;
  double rmse = 0, mean = 0, deviation = 0, median = 0, p90 = 0, max = 0;  ///< NaN without errors
};
ErrorSummary summarized(const std::vector<double>& errors);

/// The 99.73 % quantile of the chi-square distribution with six degrees of freedom: an error beyond
/// it is further than three sigma (probability of a normal distribution) from the estimate.
constexpr double kThreeSigmaOfSix = 20.06;

/// Normalised estimation error squared, e^T covariance^-1 e (Bar-Shalom et al. 2001, 5.4.2): e is
/// the left increment in the map frame, position first, then rotation vector, as in
/// Localization::covariance. Mean 6 and median 5.35 if the covariance is right. Infinite if the
/// covariance is not positive definite.
double normalisedErrorSquared(const Matrix6d& covariance, const Eigen::Isometry3d& T_map_sensor,
                              const Eigen::Isometry3d& T_true);

/// How well a covariance tells the errors. NaN where there is no answer.
struct Consistency {
  std::size_t answers = 0;
  double mean = 0;  ///< of the normalised error squared over 6: 1 if right, less if it is too wide
  double median = 0;          ///< same; 0.89 if right
  double within_3_sigma = 0;  ///< share at most kThreeSigmaOfSix; 0.9973 if right
};

Consistency consistencyOf(const std::vector<double>& normalised_errors_squared);

/// An answered query beside the truth.
struct ScoredQuery {
  std::string input;
  std::int64_t first_frame = 0, last_frame = 0;
  Localization fix;
  bool negative = false;  ///< an out-of-map query: any acceptance is false, and there is no truth
  Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();  ///< T_map_sensor; valid unless negative

  bool hasPose() const { return !fix.hypotheses.empty(); }  ///< else not even a rejected one
  double positionError() const;                             ///< [m]; infinite without a pose
  double rotationError() const;                             ///< [deg]; infinite without a pose
};

/// Success over distance and angle for one choice of answers.
struct SuccessTable {
  std::vector<double> errors_m;    ///< of the answers that have a pose
  ErrorSummary ape_m, ape_deg;     ///< of the same: absolute pose errors
  std::vector<double> within_m;    ///< share for each of kDistances_m
  std::vector<double> within_deg;  ///< share for each of kAngles_deg
};

extern const std::vector<double> kDistances_m;  ///< 1, 2, 5, 10, 20, 30
extern const std::vector<double> kAngles_deg;   ///< 1, 2, 5, 10

/// Milliseconds of one stage over all queries.
struct StageTime {
  std::string name;
  ErrorSummary ms;
};

/// What a set of answers is worth. Ratios are NaN where nothing was asked.
struct Evaluation {
  double correct_within_m = 0;
  std::size_t queries = 0;                                ///< with truth
  std::size_t negatives = 0;                              ///< out-of-map queries
  std::size_t accepted = 0, ambiguous = 0, rejected = 0;  ///< of the queries with truth
  std::size_t false_accepts = 0;                          ///< of the negatives
  SuccessTable
      best;  ///< best hypothesis of every query, accepted or not (the paper's success rate)
  SuccessTable believed;  ///< accepted answers only; the share is still of all queries
  /// Of the program's own verdict; F1 is their harmonic mean, 0 if both are 0.
  double precision = 0, recall = 0, f1 = 0;
  double false_accept_rate = 0;  ///< false accepts over negatives
  double area_under_pr = 0;
  double recall_at_99 = 0;  ///< recall at 99 % precision
  std::vector<ConfidenceBand> bands;
  Consistency consistency;             ///< of the covariances of accepted answers that are correct
  ErrorSummary total_ms;               ///< per query
  std::vector<StageTime> stages;       ///< in the order of execution, and "total" at the end
  std::vector<PrecisionRecall> curve;  ///< over the confidence
};

/// A pose is correct if its position is within `correct_within_m` of the truth (paper, section IV:
/// 20 or 30 m).
Evaluation evaluate(const std::vector<ScoredQuery>& queries, double correct_within_m);

// The contents of the files that describe an evaluation; whoever calls writes them.

std::string evaluationTable(const Evaluation& evaluation);  ///< for people, some lines of text
std::string resultsCsv(const std::vector<ScoredQuery>& queries);  ///< one line per query
std::string precisionRecallCsv(const Evaluation& evaluation);     ///< one line per threshold
std::string successCsv(const Evaluation& evaluation);      ///< share of queries over the distance
std::string evaluationJson(const Evaluation& evaluation);  ///< all numbers; unknown ones are null

}  // namespace xview
