// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <filesystem>

#include "answer.h"
#include "inputs.h"
#include "outputs.h"
#include "process/atomic_file.h"
#include "scenes.h"
#include "scored_files.h"
#include "tool.h"
#include "view/scene.h"
#include "xview/base/error.h"

namespace xview::tools {
namespace {

/// Shares of queries within a distance, from a millimetre to 100 m, evenly on a log scale.
std::vector<Eigen::Vector2d> successCurve(const SuccessTable& table, std::size_t queries) {
  std::vector<Eigen::Vector2d> curve;
  for (int i = 0; i <= 100 && queries > 0; ++i) {
    const double limit = std::pow(10, -3 + 0.05 * i);
    curve.emplace_back(limit, shareWithin(table.errors_m, limit, queries));
  }
  return curve;
}

std::vector<SceneChart> chartsOf(const Evaluation& evaluation) {
  SceneChart success{
      "Queries within a distance of the truth", "distance", "queries", ChartAxis::length, {}};
  success.curves = {{"best hypothesis", successCurve(evaluation.best, evaluation.queries)},
                    {"accepted", successCurve(evaluation.believed, evaluation.queries)}};
  SceneChart precision{
      "Precision over recall", "recall", "precision", ChartAxis::share, {{"", {}}}};
  for (const PrecisionRecall& point : evaluation.curve)
    precision.curves[0].second.emplace_back(point.recall, point.precision);
  SceneChart calibration{"Right answers, and what confidence claims",
                         "confidence (dots: number of answers)",
                         "right",
                         ChartAxis::odds,
                         {}};
  for (const ConfidenceBand& band : evaluation.bands) {
    const auto answers = static_cast<double>(band.answers);
    if (band.answers > 0)
      calibration.curves.push_back(
          {std::to_string(band.answers),
           {{band.mean_confidence, static_cast<double>(band.right) / answers}}});
  }
  return {success, precision, calibration};
}

std::vector<std::pair<std::string, std::string>> factsOf(const Evaluation& e) {
  const auto percent = [](double share) {
    return std::isfinite(share) ? fmt::format("{:.1f} %", 100 * share) : std::string("-");
  };
  std::vector<std::pair<std::string, std::string>> facts = {
      {"median error", lengthText(e.believed.ape_m.median)},
      {"90 % within", lengthText(e.believed.ape_m.p90)},
      {fmt::format("precision, {} m", e.correct_within_m), percent(e.precision)},
      {"recall", percent(e.recall)},
      {"time per query", fmt::format("{:.2f} s", e.total_ms.median / 1000)}};
  if (e.negatives > 0)
    facts.emplace_back("negatives accepted", fmt::format("{} of {}", e.false_accepts, e.negatives));
  return facts;
}

class EvaluateCommand final : public Command {
 public:
  Description describe() const override {
    return {"evaluate",
            "RESULTS TRUTH [RESULTS TRUTH]...",
            "errors, success rate over distance, precision-recall",
            "RESULTS is what localize --json printed, or a trajectory (TUM, KITTI) such as that of "
            "localize --trajectory; TRUTH holds TUM or KITTI poses of the query's frames in the "
            "map frame. Several pairs are judged together. With -o the folder gets results.csv, "
            "pr.csv, success.csv, summary.json, the charts success.svg, pr.svg and "
            "calibration.svg, and report.html.",
            "xview evaluate rear.jsonl town/rear/groundtruth.txt -o report --map town.xvm",
            2,
            100000};
  }

  void declare(Flags& flags) override {
    flags.addOutput("-o,--out DIR", out_, "folder for the files; made if missing");
    flags.add("--negatives", negatives_, "answers to out-of-map queries, which must be refused");
    flags.add("--within", within_m_,
              "an answer is correct if its position is this near the truth [m]");
    flags.add("--map", map_, "draw this map in report.html, not that which RESULTS name");
    input_.declare(flags);
  }

  ExitCode run(const Job& job) override {
    if (!(within_m_ > 0)) throw UsageError(fmt::format("--within = {}, must be > 0", within_m_));
    if (job.operands.size() % 2 != 0)
      throw UsageError(job.operands.back() + " has no TRUTH: RESULTS and TRUTH come in pairs");
    const std::vector<ScoredQuery> queries = score(job);
    const Evaluation evaluation = evaluate(queries, within_m_);
    if (!out_.empty()) {
      const std::string path = mapPath(job);
      const map::SemanticMap map =
          path.empty() ? map::SemanticMap() : readWholeMap(path, input_, job);
      writeAll(evaluation, queries, map, job);
    }
    fmt::print("{}", evaluationTable(evaluation));
    if (!out_.empty()) job.narrate.summary(out_ + "/report.html");
    return kDone;
  }

 private:
  /// --map, or the map that the first answers name, if it is found.
  std::string mapPath(const Job& job) const {
    const std::string& results = job.operands[0];
    if (!map_.empty() || isTrajectory(results)) return map_;
    const std::string map = readAnswers(results)[0].map;
    const std::string path = map.empty() ? "" : foundPath(map, results, {});
    return std::filesystem::exists(path) ? path : "";
  }

  static void judge(const ScoredQuery& scored, SceneQuery& query) {
    query.out_of_map = scored.negative;
    if (scored.negative) return;
    query.true_poses = {scored.truth};
    if (!scored.hasPose()) return;
    query.error_m = scored.positionError();
    query.error_deg = scored.rotationError();
  }

  /// The map with all queries, those out of the map last, as in `scored`.
  std::string reportPage(const Evaluation& evaluation, const std::vector<ScoredQuery>& scored,
                         const std::vector<SceneChart>& charts, const map::SemanticMap& map,
                         const Job& job) const {
    Scene scene = sceneOf(map);
    JoinedLabels labels;  // of queries; ids of the map stay
    labels.take(map.labels);
    DrawnAnswers drawn(input_, kReportVoxel_m, job, {});
    std::vector<std::string> files;
    for (std::size_t i = 0; i < job.operands.size(); i += 2) files.push_back(job.operands[i]);
    if (!negatives_.empty()) files.push_back(negatives_);
    for (const std::string& file : files) {
      if (!isTrajectory(file)) {
        for (SceneQuery& query : drawn.draw(file, labels, !map.graph.empty() || !map.cloud.empty()))
          scene.queries.push_back(std::move(query));
        continue;
      }
      for (std::size_t i = scene.queries.size(); i < scored.size() && scored[i].input == file;
           ++i) {
        SceneQuery query;
        query.name = fmt::format("pose {}", scored[i].first_frame);
        query.poses = {scored[i].fix.T_map_sensor};
        scene.queries.push_back(std::move(query));
      }
    }
    for (std::size_t i = 0; i < scored.size(); ++i) judge(scored[i], scene.queries[i]);
    scene.labels = &labels.labels();
    scene.title = fmt::format("{} of {} found, median {} off", evaluation.accepted,
                              evaluation.queries, lengthText(evaluation.believed.ape_m.median));
    scene.caption = fmt::format("{} against {}", job.operands[0], job.operands[1]);
    if (job.operands.size() > 2)
      scene.caption += fmt::format(" and {} more", job.operands.size() / 2 - 1);
    scene.made_by = madeBy(job);
    scene.facts = factsOf(evaluation);
    scene.charts = charts;
    return htmlPage(scene, kReportPoints);
  }

  static constexpr double kReportVoxel_m = 0.3;
  static constexpr std::size_t kReportPoints = 300000;

  std::vector<ScoredQuery> score(const Job& job) const {
    std::vector<ScoredQuery> queries;
    for (std::size_t i = 0; i < job.operands.size(); i += 2) {
      const auto of_file = scoredFile(job.operands[i], job.operands[i + 1], job.narrate);
      queries.insert(queries.end(), of_file.begin(), of_file.end());
    }
    if (negatives_.empty()) return queries;
    for (const Answer& answer : readAnswers(negatives_))
      queries.push_back({answer.input, answer.first_frame, answer.last_frame, answer.fix, true});
    return queries;
  }

  /// All of the files or, if the largest does not fit, none.
  void writeAll(const Evaluation& evaluation, const std::vector<ScoredQuery>& queries,
                const map::SemanticMap& map, const Job& job) const {
    const std::vector<SceneChart> charts = chartsOf(evaluation);
    const std::pair<const char*, std::string> contents[] = {
        {"report.html", reportPage(evaluation, queries, charts, map, job)},
        {"results.csv", resultsCsv(queries)},
        {"success.csv", successCsv(evaluation)},
        {"pr.csv", precisionRecallCsv(evaluation)},
        {"summary.json", evaluationJson(evaluation)},
        {"success.svg", chartSvg(charts[0])},
        {"pr.svg", chartSvg(charts[1])},
        {"calibration.svg", chartSvg(charts[2])}};
    const bool is_new = makeFolder(out_);
    try {
      std::deque<AtomicFile> files;
      for (const auto& [name, content] : contents)
        files.emplace_back(out_ + "/" + name).write(content);
      for (AtomicFile& file : files) file.commit();
    } catch (const Error&) {
      std::error_code problem;
      if (is_new) std::filesystem::remove(out_, problem);
      throw;
    }
  }

  InputFlags input_;
  std::string out_, negatives_, map_;
  double within_m_ = 5;
};

}  // namespace

std::unique_ptr<Command> makeEvaluate() { return std::make_unique<EvaluateCommand>(); }

}  // namespace xview::tools
