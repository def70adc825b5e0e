// SPDX-License-Identifier: BSD-3-Clause
#include "xview/eval/evaluation.h"

#include <algorithm>
#include <functional>
#include <limits>

#include "xview/eval/statistics.h"
#include "xview/types/pose.h"

namespace xview {
namespace {

constexpr double kDegrees = 57.29577951308232;
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

using Choice = std::function<bool(const ScoredQuery&)>;

SuccessTable successOf(const std::vector<ScoredQuery>& queries, std::size_t total,
                       const Choice& chosen) {
  std::vector<double> metres, degrees;
  for (const ScoredQuery& query : queries) {
    if (query.negative || !query.has_pose || !chosen(query)) continue;
    metres.push_back(query.positionError());
    degrees.push_back(kDegrees * query.rotationError());
  }
  SuccessTable table;
  for (const double limit : kDistances_m)
    table.within_m.push_back(shareWithin(metres, limit, total));
  for (const double limit : kAngles_deg)
    table.within_deg.push_back(shareWithin(degrees, limit, total));
  table.median_m = quantile(metres, 0.5);
  table.p90_m = quantile(metres, 0.9);
  table.median_deg = quantile(degrees, 0.5);
  table.p90_deg = quantile(degrees, 0.9);
  return table;
}

bool isCorrect(const ScoredQuery& query, double within_m) {
  return !query.negative && query.has_pose && query.positionError() <= within_m;
}

double ratio(std::size_t part, std::size_t whole) {
  return whole == 0 ? kUnknown : static_cast<double>(part) / static_cast<double>(whole);
}

void countVerdicts(const std::vector<ScoredQuery>& queries, Evaluation& result) {
  for (const ScoredQuery& query : queries) {
    const bool accepted = query.status == Status::accepted;
    if (query.negative) {
      ++result.negatives;
      result.false_accepts += accepted;
      continue;
    }
    ++result.queries;
    result.accepted += accepted;
    result.ambiguous += query.status == Status::ambiguous;
    result.rejected += query.status == Status::rejected;
  }
}

/// Median of every stage that any query has, "total" left out.
Timings mediansOf(const std::vector<ScoredQuery>& queries) {
  std::vector<std::pair<std::string, std::vector<double>>> stages;
  for (const ScoredQuery& query : queries) {
    for (const auto& [name, ms] : query.timing_ms) {
      if (name == "total") continue;
      auto stage = std::find_if(stages.begin(), stages.end(),
                                [&n = name](const auto& s) { return s.first == n; });
      if (stage == stages.end()) stage = stages.insert(stages.end(), {name, {}});
      stage->second.push_back(ms);
    }
  }
  Timings medians;
  for (const auto& [name, values] : stages) medians.emplace_back(name, quantile(values, 0.5));
  return medians;
}

}  // namespace

const std::vector<double> kDistances_m{1, 2, 5, 10, 20, 30};
const std::vector<double> kAngles_deg{1, 2, 5, 10};

double ScoredQuery::positionError() const {
  return has_pose ? (estimate.translation() - truth.translation()).norm() : kInfinite;
}

double ScoredQuery::rotationError() const {
  return has_pose ? rotationBetween(estimate, truth) : kInfinite;
}

double ScoredQuery::totalMs() const {
  const auto total = std::find_if(timing_ms.begin(), timing_ms.end(),
                                  [](const auto& t) { return t.first == "total"; });
  return total == timing_ms.end() ? 0 : total->second;
}

Evaluation evaluate(const std::vector<ScoredQuery>& queries, double correct_within_m) {
  Evaluation result;
  result.correct_within_m = correct_within_m;
  countVerdicts(queries, result);
  result.best = successOf(queries, result.queries, [](const ScoredQuery&) { return true; });
  result.believed = successOf(queries, result.queries,
                              [](const ScoredQuery& q) { return q.status == Status::accepted; });

  std::vector<Detection> detections;
  std::vector<double> times, normalised;
  std::size_t hits = 0;
  for (const ScoredQuery& query : queries) {
    const bool correct = isCorrect(query, correct_within_m);
    const bool hit = correct && query.status == Status::accepted;
    hits += hit;
    if (hit && query.has_covariance)
      normalised.push_back(normalisedErrorSquared(query.covariance, query.estimate, query.truth));
    times.push_back(query.totalMs());
    if (query.has_pose) detections.push_back({query.confidence, correct});
  }
  result.precision = ratio(hits, result.accepted + result.false_accepts);
  result.recall = ratio(hits, result.queries);
  result.f1 = f1Score(result.precision, result.recall);
  result.curve = precisionRecallCurve(detections, result.queries);
  result.area_under_pr = result.queries == 0 ? kUnknown : averagePrecision(result.curve);
  result.consistency = consistencyOf(normalised);
  result.median_ms = quantile(times, 0.5);
  result.p90_ms = quantile(times, 0.9);
  result.stages_ms = mediansOf(queries);
  return result;
}

}  // namespace xview
