// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>

#include <filesystem>

#include "answer_file.h"
#include "commands.h"
#include "inputs.h"
#include "truth_file.h"
#include "xview/eval/report.h"
#include "xview/io/atomic_file.h"
#include "xview/types/error.h"

namespace xview::tools {
namespace {

ScoredQuery withoutTruth(const Answer& answer) {
  ScoredQuery query;
  query.input = answer.input;
  query.first_frame = answer.first_frame;
  query.last_frame = answer.last_frame;
  query.status = answer.fix.status;
  query.confidence = answer.fix.confidence;
  query.has_pose = !answer.fix.hypotheses.empty();
  query.estimate = answer.fix.T_map_sensor;
  query.has_covariance = !answer.fix.covariance.isZero();
  query.covariance = answer.fix.covariance;
  query.timing_ms = answer.fix.timing_ms;
  return query;
}

/// The map as points for the report, at most some ten thousand.
std::vector<ReportPoint> reportPoints(const SemanticMap& map) {
  std::vector<ReportPoint> points;
  const auto add = [&](const Eigen::Vector3d& p, std::uint32_t label) {
    const auto color = map.labels.color(label);
    points.push_back({static_cast<float>(p.x()), static_cast<float>(p.y()),
                      static_cast<float>(p.z()),
                      color[0] * 0x10000u + color[1] * 0x100u + color[2]});
  };
  constexpr std::size_t kMost = 30000;
  const std::size_t step = map.cloud.size() / kMost + 1;
  for (std::size_t i = 0; i < map.cloud.size(); i += step)
    add(map.cloud.position(i), map.cloud.points[i].label);
  if (map.cloud.empty()) {
    for (const Vertex& vertex : map.graph.vertices) add(vertex.position, vertex.label);
  }
  return points;
}

class EvaluateCommand final : public Command {
 public:
  Description describe() const override {
    return {"evaluate",
            "RESULTS.jsonl TRUTH",
            "errors, success rate over distance, precision-recall",
            "RESULTS.jsonl is what localize --json printed; TRUTH holds TUM or KITTI poses of the "
            "query's frames in the map\n"
            "frame. With -o the folder gets results.csv, pr.csv, success.csv, summary.json and "
            "report.html.",
            "xview evaluate rear.jsonl town/rear/groundtruth.txt -o report --map town.xvm",
            2,
            2};
  }

  void declare(Flags& flags) override {
    flags.add("-o,--out", out_, "folder for the files; made if missing");
    flags.add("--negatives", negatives_,
              "answers to queries from elsewhere, which must be refused");
    flags.add("--within", within_m_,
              "an answer is correct if its position is this near the truth [m]");
    flags.add("--map", map_, "draw this map in report.html");
    input_.declare(flags);
  }

  ExitCode run(const Job& job) override {
    if (!(within_m_ > 0)) throw UsageError(fmt::format("--within = {}, must be > 0", within_m_));
    const std::vector<ScoredQuery> queries = score(job.operands[0], Truth(job.operands[1]));
    const Evaluation evaluation = evaluate(queries, within_m_);
    if (!out_.empty()) {
      const std::vector<ReportPoint> points =
          map_.empty() ? std::vector<ReportPoint>() : reportPoints(readMap(map_, input_, job));
      writeAll(evaluation, queries, points);
      job.narrate.note(out_ + "/report.html written");
    }
    fmt::print("{}", evaluationTable(evaluation));
    return kDone;
  }

 private:
  std::vector<ScoredQuery> score(const std::string& results, const Truth& truth) const {
    std::vector<ScoredQuery> queries;
    for (const Answer& answer : readAnswers(results)) {
      queries.push_back(withoutTruth(answer));
      queries.back().truth = truth.poseFor(answer);
    }
    if (negatives_.empty()) return queries;
    for (const Answer& answer : readAnswers(negatives_)) {
      queries.push_back(withoutTruth(answer));
      queries.back().negative = true;
    }
    return queries;
  }

  void writeAll(const Evaluation& evaluation, const std::vector<ScoredQuery>& queries,
                const std::vector<ReportPoint>& points) const {
    std::error_code problem;
    const bool is_new = std::filesystem::create_directories(out_, problem);
    if (problem) throw Error(out_, "cannot be made: " + problem.message());
    try {
      writeFiles(evaluation, queries, points);
    } catch (const Error&) {
      if (is_new) std::filesystem::remove(out_, problem);
      throw;
    }
  }

  /// All of them or, if the largest does not fit, none.
  void writeFiles(const Evaluation& evaluation, const std::vector<ScoredQuery>& queries,
                  const std::vector<ReportPoint>& points) const {
    AtomicFile report(out_ + "/report.html"), results(out_ + "/results.csv"),
        success(out_ + "/success.csv"), pr(out_ + "/pr.csv"), summary(out_ + "/summary.json");
    report.write(reportHtml(evaluation, queries, points));
    results.write(resultsCsv(queries));
    success.write(successCsv(queries));
    pr.write(precisionRecallCsv(evaluation));
    summary.write(evaluationJson(evaluation));
    for (AtomicFile* file : {&report, &results, &success, &pr, &summary}) file->commit();
  }

  InputFlags input_;
  std::string out_, negatives_, map_;
  double within_m_ = 5;
};

}  // namespace

std::unique_ptr<Command> makeEvaluate() { return std::make_unique<EvaluateCommand>(); }

}  // namespace xview::tools
