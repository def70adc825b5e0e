// SPDX-License-Identifier: BSD-3-Clause
#include "xview/eval/report.h"

#include <fmt/core.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "xview/types/pose.h"

namespace xview {
namespace {

using Json = nlohmann::ordered_json;
constexpr double kDegrees = 57.29577951308232;

std::string percent(double share) {
  return std::isnan(share) ? "-" : fmt::format("{:.1f}", 100 * share);
}
std::string number(double value, int digits) {
  return std::isnan(value) ? "-" : fmt::format("{:.{}f}", value, digits);
}

std::string successLine(const std::string& name, const SuccessTable& table) {
  std::string line = fmt::format("{:<16}", name);
  for (const double share : table.within_m) line += fmt::format("{:>7}", percent(share));
  line += "  |";
  for (const double share : table.within_deg) line += fmt::format("{:>7}", percent(share));
  return line + "\n";
}

std::string errorLine(const std::string& name, const SuccessTable& table) {
  return fmt::format("{:<16} median {} m, {} deg; p90 {} m, {} deg\n", name,
                     number(table.median_m, 3), number(table.median_deg, 3), number(table.p90_m, 3),
                     number(table.p90_deg, 3));
}

/// Text in quotes as CSV has it.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

std::string poseColumns(const Eigen::Isometry3d& pose, bool known) {
  if (!known) return ",,";
  const Eigen::Vector3d p = pose.translation();
  return fmt::format("{:.6f},{:.6f},{:.6f}", p.x(), p.y(), p.z());
}

Json successJson(const SuccessTable& table) {
  Json json;
  for (std::size_t i = 0; i < kDistances_m.size(); ++i) {
    json["within_m"][fmt::format("{}", kDistances_m[i])] = table.within_m[i];
  }
  for (std::size_t i = 0; i < kAngles_deg.size(); ++i) {
    json["within_deg"][fmt::format("{}", kAngles_deg[i])] = table.within_deg[i];
  }
  json["median_m"] = table.median_m;
  json["p90_m"] = table.p90_m;
  json["median_deg"] = table.median_deg;
  json["p90_deg"] = table.p90_deg;
  return json;
}

}  // namespace

std::string evaluationTable(const Evaluation& e) {
  std::string text = fmt::format("{} queries: {} accepted, {} ambiguous, {} rejected", e.queries,
                                 e.accepted, e.ambiguous, e.rejected);
  if (e.negatives > 0)
    text += fmt::format("; {} of {} from elsewhere falsely accepted", e.false_accepts, e.negatives);
  text += fmt::format("\n\n{:<16}", "success [%]");
  for (const double limit : kDistances_m) text += fmt::format("{:>7}", fmt::format("{} m", limit));
  text += "  |";
  for (const double limit : kAngles_deg) text += fmt::format("{:>7}", fmt::format("{} deg", limit));
  text +=
      "\n" + successLine("best hypothesis", e.best) + successLine("accepted", e.believed) + "\n";
  text += errorLine("best hypothesis", e.best) + errorLine("accepted", e.believed) + "\n";
  text +=
      fmt::format("precision {} %, recall {} %, F1 {}, area under PR {} (correct: within {} m)\n",
                  percent(e.precision), percent(e.recall), number(e.f1, 4),
                  number(e.area_under_pr, 4), e.correct_within_m);
  if (e.consistency.answers > 0)
    text += fmt::format(
        "covariance of {} right answers: normalised error squared over 6 mean {} (1 if right), "
        "median {} (0.89), within 3 sigma {} %\n",
        e.consistency.answers, number(e.consistency.mean, 2), number(e.consistency.median, 2),
        percent(e.consistency.within_3_sigma));
  text += fmt::format("time per query: median {} ms, p90 {} ms\n", number(e.median_ms, 1),
                      number(e.p90_ms, 1));
  std::string stages;
  for (const auto& [name, ms] : e.stages_ms) {
    stages += fmt::format("{} {} {}", stages.empty() ? "" : ",", name, number(ms, 1));
  }
  return stages.empty() ? text : text + "median per stage [ms]:" + stages + "\n";
}

std::string resultsCsv(const std::vector<ScoredQuery>& queries) {
  std::string csv =
      "input,first_frame,last_frame,negative,status,confidence,error_m,error_deg,x_m,y_m,z_m,true_"
      "x_m,true_y_m,true_z_m,"
      "total_ms\n";
  for (const ScoredQuery& q : queries) {
    const bool measured = q.has_pose && !q.negative;
    csv += fmt::format("{},{},{},{},{},{},", quoted(q.input), q.first_frame, q.last_frame,
                       q.negative ? 1 : 0, toString(q.status), q.confidence);
    csv += measured ? fmt::format("{:.6f},{:.6f},", q.positionError(), kDegrees * q.rotationError())
                    : ",,";
    csv += fmt::format("{},{},{:.3f}\n", poseColumns(q.estimate, q.has_pose),
                       poseColumns(q.truth, !q.negative), q.totalMs());
  }
  return csv;
}

std::string precisionRecallCsv(const Evaluation& evaluation) {
  std::string csv = "threshold,precision,recall\n";
  for (const PrecisionRecall& point : evaluation.curve) {
    csv += fmt::format("{},{},{}\n", point.threshold, point.precision, point.recall);
  }
  return csv;
}

std::string successCsv(const std::vector<ScoredQuery>& queries) {
  std::vector<double> best, believed;
  std::size_t total = 0;
  for (const ScoredQuery& query : queries) {
    if (query.negative) continue;
    ++total;
    best.push_back(query.positionError());
    if (query.status == Status::accepted) believed.push_back(query.positionError());
  }
  std::string csv = "distance_m,success_best,success_accepted\n";
  constexpr int kSteps = 300;
  for (int i = 0; i <= kSteps && total > 0; ++i) {
    const double limit = 0.1 * i;
    csv += fmt::format("{:.1f},{},{}\n", limit, shareWithin(best, limit, total),
                       shareWithin(believed, limit, total));
  }
  return csv;
}

std::string evaluationJson(const Evaluation& e) {
  Json json;
  json["queries"] = e.queries;
  json["accepted"] = e.accepted;
  json["ambiguous"] = e.ambiguous;
  json["rejected"] = e.rejected;
  json["negatives"] = e.negatives;
  json["false_accepts"] = e.false_accepts;
  json["correct_within_m"] = e.correct_within_m;
  json["precision"] = e.precision;
  json["recall"] = e.recall;
  json["f1"] = e.f1;
  json["area_under_pr"] = e.area_under_pr;
  json["covariance"]["answers"] = e.consistency.answers;
  json["covariance"]["nees_over_6_mean"] = e.consistency.mean;
  json["covariance"]["nees_over_6_median"] = e.consistency.median;
  json["covariance"]["within_3_sigma"] = e.consistency.within_3_sigma;
  json["best_hypothesis"] = successJson(e.best);
  json["accepted_only"] = successJson(e.believed);
  json["median_ms"] = e.median_ms;
  json["p90_ms"] = e.p90_ms;
  for (const auto& [name, ms] : e.stages_ms) json["stages_ms"][name] = ms;
  return json.dump(2) + "\n";  // NaN becomes null
}

}  // namespace xview
