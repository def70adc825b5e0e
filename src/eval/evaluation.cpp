// SPDX-License-Identifier: BSD-3-Clause
#include "eval/evaluation.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

#include "base/in_order.h"
#include "base/pose.h"

namespace xview {
namespace {

constexpr double kDegrees = 57.29577951308232;
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr double kFreedom = 6;  // of a pose
constexpr double kInfinite = std::numeric_limits<double>::infinity();

SuccessTable successOf(const std::vector<ScoredQuery>& queries, std::size_t total,
                       bool accepted_only) {
  SuccessTable table;
  std::vector<double> degrees;
  for (const ScoredQuery& query : queries) {
    if (query.negative || !query.hasPose() || (accepted_only && !query.fix.accepted())) continue;
    table.errors_m.push_back(query.positionError());
    degrees.push_back(query.rotationError());
  }
  for (const double limit : kDistances_m)
    table.within_m.push_back(shareWithin(table.errors_m, limit, total));
  for (const double limit : kAngles_deg)
    table.within_deg.push_back(shareWithin(degrees, limit, total));
  table.ape_m = summarized(table.errors_m);
  table.ape_deg = summarized(degrees);
  return table;
}

bool isCorrect(const ScoredQuery& query, double within_m) {
  return !query.negative && query.hasPose() && query.positionError() <= within_m;
}

double ratio(std::size_t part, std::size_t whole) {
  return whole == 0 ? kUnknown : static_cast<double>(part) / static_cast<double>(whole);
}

void countVerdicts(const std::vector<ScoredQuery>& queries, Evaluation& result) {
  for (const ScoredQuery& query : queries) {
    if (query.negative) {
      ++result.negatives;
      result.false_accepts += query.fix.accepted();
      continue;
    }
    ++result.queries;
    result.accepted += query.fix.accepted();
    result.ambiguous += query.fix.status == Status::ambiguous;
    result.rejected += query.fix.status == Status::rejected;
  }
}

/// Every stage that any query has, "total" last.
std::vector<StageTime> stageTimes(const std::vector<ScoredQuery>& queries) {
  std::vector<std::pair<std::string, std::vector<double>>> stages;
  std::vector<double> totals;
  for (const ScoredQuery& query : queries) {
    for (const auto& [name, ms] : query.fix.timing_ms)
      (name == "total" ? totals : valueOf(stages, name)).push_back(ms);
  }
  if (!totals.empty()) stages.emplace_back("total", std::move(totals));
  std::vector<StageTime> times;
  for (const auto& [name, values] : stages) times.push_back({name, summarized(values)});
  return times;
}

}  // namespace

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return kUnknown;
  std::sort(values.begin(), values.end());
  const double rank = std::clamp(q, 0.0, 1.0) * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(rank);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  const double part = rank - static_cast<double>(below);
  return part == 0 ? values[below] : values[below] + part * (values[above] - values[below]);
}

double shareWithin(const std::vector<double>& values, double limit, std::size_t total) {
  if (total == 0) return kUnknown;
  const auto within =
      std::count_if(values.begin(), values.end(), [&](double v) { return v <= limit; });
  return static_cast<double>(within) / static_cast<double>(total);
}

std::vector<PrecisionRecall> precisionRecallCurve(std::vector<Detection> detections,
                                                  std::size_t positives) {
  std::sort(detections.begin(), detections.end(),
            [](const Detection& a, const Detection& b) { return a.confidence > b.confidence; });
  std::vector<PrecisionRecall> curve;
  std::size_t correct = 0;
  for (std::size_t i = 0; i < detections.size(); ++i) {
    correct += detections[i].correct;
    const bool tied =
        i + 1 < detections.size() && detections[i + 1].confidence == detections[i].confidence;
    if (tied) continue;  // equally sure answers are believed together
    const auto hits = static_cast<double>(correct);
    curve.push_back({detections[i].confidence, hits / static_cast<double>(i + 1),
                     positives == 0 ? 0 : hits / static_cast<double>(positives)});
  }
  return curve;
}

double averagePrecision(const std::vector<PrecisionRecall>& curve) {
  double area = 0, recall = 0;
  for (const PrecisionRecall& point : curve) {
    area += (point.recall - recall) * point.precision;
    recall = point.recall;
  }
  return area;
}

double recallAtPrecision(const std::vector<PrecisionRecall>& curve, double precision) {
  double recall = 0;
  for (const PrecisionRecall& point : curve) {
    if (point.precision >= precision) recall = std::max(recall, point.recall);
  }
  return recall;
}

std::vector<ConfidenceBand> confidenceBands(const std::vector<Detection>& detections) {
  constexpr double kEdges[] = {0, 0.1, 0.5, 0.8, 0.9, 0.95, 0.98, 0.99, 0.999, 1};
  std::vector<ConfidenceBand> bands;
  for (std::size_t i = 0; i + 1 < std::size(kEdges); ++i) {
    ConfidenceBand band{kEdges[i], kEdges[i + 1]};
    double sum = 0;
    for (const Detection& d : detections) {
      const bool is_inside =
          d.confidence >= band.low && (d.confidence < band.high || band.high == 1);
      if (!is_inside) continue;
      ++band.answers;
      band.right += d.correct;
      sum += d.confidence;
    }
    band.mean_confidence = band.answers == 0 ? kUnknown : sum / static_cast<double>(band.answers);
    bands.push_back(band);
  }
  return bands;
}

ErrorSummary summarized(const std::vector<double>& errors) {
  ErrorSummary result;
  result.count = errors.size();
  const auto n = static_cast<double>(errors.size());
  const double squares = std::inner_product(errors.begin(), errors.end(), errors.begin(), 0.0);
  result.rmse = std::sqrt(squares / n);
  result.mean = std::accumulate(errors.begin(), errors.end(), 0.0) / n;
  result.deviation = std::sqrt(std::max(0.0, squares / n - result.mean * result.mean));
  result.median = quantile(errors, 0.5);
  result.p90 = quantile(errors, 0.9);
  result.max = quantile(errors, 1);
  return result;
}

double normalisedErrorSquared(const Matrix6d& covariance, const Eigen::Isometry3d& T_map_sensor,
                              const Eigen::Isometry3d& T_true) {
  const Eigen::AngleAxisd turn(
      Eigen::Matrix3d(T_true.linear() * T_map_sensor.linear().transpose()));
  Eigen::Matrix<double, 6, 1> error;
  error << T_true.translation() - T_map_sensor.translation(), turn.angle() * turn.axis();
  const Eigen::LLT<Matrix6d> root(covariance);
  if (root.info() != Eigen::Success) return kInfinite;
  return root.matrixL().solve(error).squaredNorm();
}

Consistency consistencyOf(const std::vector<double>& normalised_errors_squared) {
  const std::vector<double>& values = normalised_errors_squared;
  Consistency result;
  result.answers = values.size();
  result.mean = std::accumulate(values.begin(), values.end(), 0.0) /
                (kFreedom * static_cast<double>(values.size()));
  result.median = quantile(values, 0.5) / kFreedom;
  result.within_3_sigma = shareWithin(values, kThreeSigmaOfSix, values.size());
  return result;
}

const std::vector<double> kDistances_m{1, 2, 5, 10, 20, 30};
const std::vector<double> kAngles_deg{1, 2, 5, 10};

double ScoredQuery::positionError() const {
  return hasPose() ? (fix.T_map_sensor.translation() - truth.translation()).norm() : kInfinite;
}

double ScoredQuery::rotationError() const {
  return hasPose() ? kDegrees * rotationBetween(fix.T_map_sensor, truth) : kInfinite;
}

Evaluation evaluate(const std::vector<ScoredQuery>& queries, double correct_within_m) {
  Evaluation result;
  result.correct_within_m = correct_within_m;
  countVerdicts(queries, result);
  result.best = successOf(queries, result.queries, false);
  result.believed = successOf(queries, result.queries, true);

  std::vector<Detection> detections;
  std::vector<double> times, normalised;
  std::size_t hits = 0;
  for (const ScoredQuery& query : queries) {
    const bool correct = isCorrect(query, correct_within_m);
    const bool hit = correct && query.fix.accepted();
    hits += hit;
    if (hit && !query.fix.covariance.isZero())
      normalised.push_back(
          normalisedErrorSquared(query.fix.covariance, query.fix.T_map_sensor, query.truth));
    times.push_back(timeOf(query.fix.timing_ms, "total"));
    if (query.hasPose()) detections.push_back({query.fix.confidence, correct});
  }
  result.precision = ratio(hits, result.accepted + result.false_accepts);
  result.recall = ratio(hits, result.queries);
  result.false_accept_rate = ratio(result.false_accepts, result.negatives);
  const double sum = result.precision + result.recall;
  result.f1 = sum == 0 ? 0 : 2 * result.precision * result.recall / sum;
  result.curve = precisionRecallCurve(detections, result.queries);
  result.area_under_pr = result.queries == 0 ? kUnknown : averagePrecision(result.curve);
  result.recall_at_99 = result.queries == 0 ? kUnknown : recallAtPrecision(result.curve, 0.99);
  result.bands = confidenceBands(detections);
  result.consistency = consistencyOf(normalised);
  result.total_ms = summarized(times);
  result.stages = stageTimes(queries);
  return result;
}

}  // namespace xview
