// SPDX-License-Identifier: BSD-3-Clause
#include "eval/evaluation.h"

#include <fmt/core.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/user_text.h"

namespace xview {
namespace {

using Json = nlohmann::ordered_json;

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
                     number(table.ape_m.median, 3), number(table.ape_deg.median, 3),
                     number(table.ape_m.p90, 3), number(table.ape_deg.p90, 3));
}

std::string apeLine(const std::string& name, const SuccessTable& table) {
  return fmt::format("{:<16} rmse {} m, mean {}, deviation {}, max {}; rmse {} deg ({} poses)\n",
                     name, number(table.ape_m.rmse, 4), number(table.ape_m.mean, 4),
                     number(table.ape_m.deviation, 4), number(table.ape_m.max, 4),
                     number(table.ape_deg.rmse, 3), table.ape_m.count);
}

/// How sure the answers were, and how many of them were right.
std::string bandTable(const std::vector<ConfidenceBand>& bands) {
  std::string text =
      fmt::format("{:<16}{:>9}{:>9}{:>10}\n", "confidence", "answers", "mean", "right");
  for (const ConfidenceBand& band : bands) {
    if (band.answers == 0) continue;
    text +=
        fmt::format("{:<16}{:>9}{:>9}{:>8} %\n", fmt::format("{} to {}", band.low, band.high),
                    band.answers, number(band.mean_confidence, 4),
                    percent(static_cast<double>(band.right) / static_cast<double>(band.answers)));
  }
  return text;
}

std::string timeTable(const std::vector<StageTime>& stages) {
  std::string text =
      fmt::format("{:<16}{:>10}{:>10}{:>11}\n", "time [ms]", "median", "mean", "deviation");
  for (const StageTime& stage : stages)
    text += fmt::format("{:<16}{:>10.1f}{:>10.1f}{:>11.1f}\n", stage.name, stage.ms.median,
                        stage.ms.mean, stage.ms.deviation);
  return text;
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
  json["rmse_m"] = table.ape_m.rmse;
  json["mean_m"] = table.ape_m.mean;
  json["deviation_m"] = table.ape_m.deviation;
  json["max_m"] = table.ape_m.max;
  json["rmse_deg"] = table.ape_deg.rmse;
  json["median_m"] = table.ape_m.median;
  json["p90_m"] = table.ape_m.p90;
  json["median_deg"] = table.ape_deg.median;
  json["p90_deg"] = table.ape_deg.p90;
  return json;
}

}  // namespace

std::string evaluationTable(const Evaluation& e) {
  std::string text = fmt::format("{} queries: {} accepted, {} ambiguous, {} rejected", e.queries,
                                 e.accepted, e.ambiguous, e.rejected);
  if (e.negatives > 0)
    text += fmt::format("; {} of {} from elsewhere falsely accepted ({} %)", e.false_accepts,
                        e.negatives, percent(e.false_accept_rate));
  text += fmt::format("\n\n{:<16}", "success [%]");
  for (const double limit : kDistances_m) text += fmt::format("{:>7}", fmt::format("{} m", limit));
  text += "  |";
  for (const double limit : kAngles_deg) text += fmt::format("{:>7}", fmt::format("{} deg", limit));
  text +=
      "\n" + successLine("best hypothesis", e.best) + successLine("accepted", e.believed) + "\n";
  text += errorLine("best hypothesis", e.best) + errorLine("accepted", e.believed) +
          apeLine("accepted", e.believed) + "\n";
  text += fmt::format(
      "precision {} %, recall {} %, F1 {}, area under PR {}\n"
      "recall at 99 % precision {} % (correct: within {} m)\n",
      percent(e.precision), percent(e.recall), number(e.f1, 4), number(e.area_under_pr, 4),
      percent(e.recall_at_99), e.correct_within_m);
  if (e.consistency.answers > 0)
    text += fmt::format(
        "covariance of {} right answers: normalised error squared over 6\n"
        "mean {} (1 if right), median {} (0.89), within 3 sigma {} %\n",
        e.consistency.answers, number(e.consistency.mean, 2), number(e.consistency.median, 2),
        percent(e.consistency.within_3_sigma));
  text += "\n" + bandTable(e.bands);
  return e.stages.empty() ? text : text + "\n" + timeTable(e.stages);
}

std::string resultsCsv(const std::vector<ScoredQuery>& queries) {
  std::string csv =
      "input,first_frame,last_frame,negative,status,confidence,error_m,error_deg,x_m,y_m,z_m,true_"
      "x_m,true_y_m,true_z_m,"
      "total_ms\n";
  for (const ScoredQuery& q : queries) {
    const bool measured = q.hasPose() && !q.negative;
    csv += fmt::format("{},{},{},{},{},{},", csvQuoted(q.input), q.first_frame, q.last_frame,
                       q.negative ? 1 : 0, toString(q.fix.status), q.fix.confidence);
    csv += measured ? fmt::format("{:.6f},{:.6f},", q.positionError(), q.rotationError()) : ",,";
    csv += fmt::format("{},{},{:.3f}\n", poseColumns(q.fix.T_map_sensor, q.hasPose()),
                       poseColumns(q.truth, !q.negative), timeOf(q.fix.timing_ms, "total"));
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

std::string successCsv(const Evaluation& e) {
  std::string csv = "distance_m,success_best,success_accepted\n";
  constexpr int kSteps = 300;
  for (int i = 0; i <= kSteps && e.queries > 0; ++i) {
    const double limit = 0.1 * i;
    csv += fmt::format("{:.1f},{},{}\n", limit, shareWithin(e.best.errors_m, limit, e.queries),
                       shareWithin(e.believed.errors_m, limit, e.queries));
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
  json["false_accept_rate"] = e.false_accept_rate;
  json["area_under_pr"] = e.area_under_pr;
  json["recall_at_99_precision"] = e.recall_at_99;
  for (const ConfidenceBand& band : e.bands)
    json["calibration"].push_back({{"from", band.low},
                                   {"to", band.high},
                                   {"answers", band.answers},
                                   {"right", band.right},
                                   {"mean_confidence", band.mean_confidence}});
  json["covariance"]["answers"] = e.consistency.answers;
  json["covariance"]["nees_over_6_mean"] = e.consistency.mean;
  json["covariance"]["nees_over_6_median"] = e.consistency.median;
  json["covariance"]["within_3_sigma"] = e.consistency.within_3_sigma;
  json["best_hypothesis"] = successJson(e.best);
  json["accepted_only"] = successJson(e.believed);
  json["median_ms"] = e.total_ms.median;
  json["p90_ms"] = e.total_ms.p90;
  for (const StageTime& stage : e.stages)
    json["stages_ms"][stage.name] = {
        {"median", stage.ms.median}, {"mean", stage.ms.mean}, {"deviation", stage.ms.deviation}};
  return json.dump(2) + "\n";  // NaN becomes null
}

}  // namespace xview
