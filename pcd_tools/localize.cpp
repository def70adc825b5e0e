// SPDX-License-Identifier: BSD-3-Clause
#include "xview/localizer.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <optional>

#include "answer.h"
#include "answer_files.h"
#include "answer_table.h"
#include "base/user_text.h"
#include "consistency_checks.h"
#include "hints.h"
#include "inputs.h"
#include "localizer/tracker.h"
#include "map/contents.h"
#include "outputs.h"
#include "place/depth_plausibility.h"
#include "scenes.h"
#include "tool.h"
#include "windows.h"
#include "xview/base/budget.h"
#include "xview/base/error.h"
#include "xview/base/frame.h"
#include "xview/base/localization.h"
#include "xview/sequence.h"

namespace xview::tools {
namespace {

/// The flags that say how a QUERY is cut into windows and how those speak to one another.
struct WindowFlags {
  int size = 0, stride = 0;
  double last_m =
      0;  ///< path length at the end of a whole recording that is the query [m]; 0 = all
  bool sequence = false;  ///< with what earlier windows say
  bool track = false;     ///< from fix to fix
  void declare(Flags& flags);
  void check() const;  ///< throws UsageError if they make no sense
};

void WindowFlags::declare(Flags& flags) {
  flags.add("--window", size, "frames per query; 0 = the whole QUERY");
  flags.add("--stride", stride, "frames from one start to the next; 0 = as --window");
  flags.add(
      "--sequence", sequence,
      "let the windows speak together: a place that gathers evidence over several is accepted");
  flags.add("--track", track, "search the next window where odometry expects it");
  last_m = kLastMetres;
  flags.rare().add(
      "--last", last_m,
      "a QUERY of one piece that is longer is found by its last metres, because odometry "
      "drifts; 0 = by all of it");
}

void WindowFlags::check() const {
  if (size < 0) throw UsageError(fmt::format("--window = {}, must be >= 0", size));
  if (stride < 0) throw UsageError(fmt::format("--stride = {}, must be >= 0", stride));
  if (!(last_m >= 0)) throw UsageError(fmt::format("--last = {}, must be >= 0", last_m));
  if (stride > 0 && size == 0) throw UsageError("--stride needs --window");
  if (sequence && size == 0) throw UsageError("--sequence needs --window");
  if (track && size == 0) throw UsageError("--track needs --window");
  if (track && sequence) throw UsageError("--track and --sequence exclude one another");
}

void logEvidence(const Answer& answer, const Narrative& narrate) {
  const Localization& fix = answer.fix;
  narrate.detail(fmt::format(
      "{}-{} {}: {}; confidence {:.6g}, log odds: place {:.1f}, correspondences {:.1f}, dense "
      "{:.1f}; {} of {} vertices kept",
      answer.first_frame, answer.last_frame, toString(fix.status), fix.reason, fix.confidence,
      fix.witnesses.place, fix.witnesses.correspondences, fix.witnesses.dense, fix.inliers,
      fix.vertices));
  narrate.detail(fmt::format("{}-{} {}: {}", answer.first_frame, answer.last_frame,
                             toString(fix.gravity), fix.gravity_reason));
  for (const Hypothesis& h : answer.fix.hypotheses) {
    const Eigen::Vector3d p = h.T_map_query.translation();
    narrate.detail(fmt::format("{}-{} {}: x {:.2f}, y {:.2f}, z {:.2f} m, score {:.1f}, {} inliers",
                               answer.first_frame, answer.last_frame, toString(h.proposer), p.x(),
                               p.y(), p.z(), h.score, h.inliers));
  }
}

void logLost(const Answer& answer, const Narrative& narrate) {
  if (!answer.track || !answer.track->lost) return;
  narrate.note(fmt::format("lost at frame {} (expected within {:.1f} m); searched everywhere: {}",
                           answer.last_frame, answer.track->radius_m, toString(answer.fix.status)));
}

/// Nobody looks for the origin of a cloud that lies beside it: people see where its middle is.
Answer asShown(const Answer& answer, const Query& query, const Narrative& narrate) {
  Answer shown = answer;
  const Eigen::Vector3d middle = arrowPose(query).translation();
  const double away_m = (middle - query.poses.back().translation()).norm();
  if (away_m == 0 || answer.fix.hypotheses.empty()) return shown;
  shown.fix = movedTo(middle, answer.fix);
  narrate.note(
      fmt::format("{}: its points lie {} away from its origin; x, y and sigma here are those "
                  "of their middle, poses in files those of the origin",
                  answer.input, lengthText(away_m)));
  return shown;
}

/// The largest coordinate of what the map holds [m].
double largestCoordinate(const map::SemanticMap& map) {
  double largest = 0;
  if (const Eigen::AlignedBox3d box = map::allVertices(map).bounds(); !box.isEmpty())
    largest = std::max(box.min().cwiseAbs().maxCoeff(), box.max().cwiseAbs().maxCoeff());
  for (const auto& pose : map.poses)
    largest = std::max(largest, pose.translation().cwiseAbs().maxCoeff());
  return largest;
}

/// How the windows of one QUERY are answered.
class WindowAnswers {
 public:
  WindowAnswers(const Localizer& localizer, const WindowFlags& flags, const Options& options)
      : localizer_(localizer) {
    if (flags.sequence) sequence_.emplace(localizer, options);
    if (flags.track) tracker_.emplace(localizer, options);
  }

  void answer(const Query& query, const Window& window, Answer& answer) {
    if (sequence_) {
      answer.sequence = sequence_->add(query, window.first, window.last);
      answer.fix = std::move(answer.sequence->fix);
    } else if (tracker_) {
      answer.track = tracker_->follow(query);
      answer.fix = std::move(answer.track->fix);
    } else {
      answer.fix = localizer_.localize(query);
    }
  }

 private:
  const Localizer& localizer_;
  std::optional<Sequence> sequence_;
  std::optional<Tracker> tracker_;
};

class LocalizeCommand final : public Command {
 public:
  Description describe() const override {
    return {
        "localize",
        "QUERY... MAP",
        "where is each query in the map?",
        "One line per QUERY, in order: accepted, ambiguous (several places fit equally well) "
        "or rejected. Exit code 0: at least one is accepted, 3: none is, 1: a QUERY could not be "
        "read; the others are answered all the same.",
        "xview localize town/rear --window 60 --stride 20 town.xvm",
        2,
        100000};
  }

  void declare(Flags& flags) override {
    input_.declareWithMap(flags);
    windows_.declare(flags);
    verdict_.declare(flags);
    flags.add("--near X,Y,RADIUS", near_, "the last pose is in this circle of the map [m]");
    flags.add("--yaw YAW,TOLERANCE", yaw_, "it looks this way, counter-clockwise from x [deg]");
    flags.add("--json", json_, "print one JSON object per query");
    flags.addOutput("-o,--out", out_, "file for the answers: .jsonl, .csv or .txt");
    files_.declare(flags);
  }

  ExitCode run(const Job& job) override {
    if (!job.options.scale.empty() && (windows_.sequence || windows_.track))
      throw UsageError("--scale is for windows on their own, without --sequence and --track");
    windows_.check();
    takeKindOfAnswers();
    files_.check(queriesOf(job));
    Job known = job;
    verdict_.applyTo(known);
    takePrior(known.options.prior);
    checkOrder(job.operands, input_);
    files_.removeOld(queriesOf(job), job, false);
    return answerAll(known);
  }

 private:
  void takeKindOfAnswers() {
    const std::string ending = endingOf(out_);
    csv_ = ending == ".csv";
    if (csv_ && json_) throw UsageError("--json and -o " + out_ + " exclude one another");
    if (!ending.empty() && !json_ && !csv_ && ending != ".jsonl" && ending != ".txt")
      throw UsageError("-o " + out_ + ": a file of answers ends with .jsonl, .csv or .txt");
    json_ = json_ || ending == ".jsonl";
  }

  /// An answer as a program reads it, if that was asked for; else as `text`.
  std::string written(const Answer& answer, const std::string& text) const {
    return json_ ? toJson(answer) : csv_ ? toCsv(answer) : text;
  }

  /// Parsed here, too, because what is wrong should be named by the flag and not by its key.
  void takePrior(PriorOptions& prior) const {
    if (!near_.empty()) {
      parseCircle("--near", near_);
      prior.near = near_;
    }
    if (!yaw_.empty()) {
      parseHeading("--yaw", yaw_);
      prior.yaw = yaw_;
    }
  }

  static std::vector<std::string> queriesOf(const Job& job) {
    return {job.operands.begin(), job.operands.end() - 1};
  }

  /// Without a map there is no pose, and none of an earlier run stays.
  map::SemanticMap readMap(const Job& job) {
    try {
      return tools::readMap(job.operands.back(), input_, job);
    } catch (const std::exception&) {
      files_.removeOld(queriesOf(job), job, true);
      throw;
    }
  }

  ExitCode answerAll(const Job& given) {
    Stopwatch watch;
    const map::SemanticMap map = readMap(given);
    const Job job = inMap(given, map);
    const Localizer localizer(map::borrowed(map), job.options, input_.parsed().class_names);
    unanswered_ = unansweredIn(map, given.operands.back(), watch.lap_ms());
    const std::vector<std::string> queries = queriesOf(job);
    Results results(out_);
    if (csv_) results.print(csvHeading(), job.narrate);
    // Who sends JSON or CSV to a file sees the table all the same.
    beside_ = (json_ || csv_) && !out_.empty() && !job.narrate.isQuiet();
    AnswerTable table(queries, largestCoordinate(map), queries.size() == 1 && windows_.size == 0,
                      beside_ ? stdout : results.screen());
    results_ = &results;
    table_ = &table;
    map_ = &map;
    const auto answer = [&](const std::string& query) {
      files_.begin(query);
      std::optional<Budget> budget;
      if (windows_.size == 0) budget.emplace(job.limits);
      const QueryInput input = openOrRead(query, map.labels, job);
      logOwnDrive(map, query, input.poses(), job.narrate);
      WindowAnswers answers(localizer, windows_, job.options);
      answerInput(input, localizer, answers, job);
      budget.reset();
      files_.complete(input, localizer, job);
    };
    for (const std::string& query : queries) {
      tryTo([&] { answer(query); }, query, job);
      tryTo([&] { files_.end(job); }, "", job);
    }
    files_.finish(map, job);
    results.finish();
    if (answered_ > 0) job.narrate.summary(table.summary());
    for (const std::string& error : errors_) job.narrate.error(error);
    if (!errors_.empty()) return kFailed;
    return accepted_ > 0 ? kDone : kNoPose;
  }

  /// What is wrong with one QUERY, misuse of it alone included, does not end the batch. It is said
  /// last, where it is seen, and has its line among the answers if `query` was to be answered.
  void tryTo(const std::function<void()>& work, const std::string& query, const Job& job) {
    try {
      work();
    } catch (const std::exception& e) {
      errors_.push_back(e.what());
      if (query.empty() || !(json_ || csv_)) return;
      Answer unread = unanswered_;
      unread.input = query;
      unread.error = oneLine(e.what());
      results_->print(written(unread, ""), job.narrate);
    }
  }

  /// A recording that is to be cut into windows is opened only.
  QueryInput openOrRead(const std::string& path, const LabelSet& map_labels, const Job& job) const {
    if (windows_.size == 0) return readQuery(path, input_, job, map_labels, windows_.last_m);
    QueryInput input = openQuery(path, input_, job, map_labels);
    if (input.source) requireKindOfDepth(*input.source);
    return input;
  }

  void answerInput(const QueryInput& input, const Localizer& localizer, WindowAnswers& answers,
                   const Job& job) {
    files_.take(input);
    if (!input.whole && static_cast<std::size_t>(windows_.size) > input.size()) {
      job.narrate.note(fmt::format("--window {} is longer than {}: its {} frames are one query",
                                   windows_.size, input.path, input.size()));
    }
    const auto answerWindow = [&](const Query& query, const Window& window) {
      Answer answer = answerFor(input, window, query, unanswered_);
      answers.answer(query, window, answer);
      answer.budget_exhausted = exhaustedBudget();
      answer.heading_rad = headingOf(answer.fix.T_map_sensor.linear(), query.sensor);
      ++answered_;
      accepted_ += answer.fix.accepted();
      files_.add(answer, query, [&] { return localizer.explain(query, answer.fix); });
      logLost(answer, job.narrate);
      logEvidence(answer, job.narrate);
      const std::string lines = table_->add(asShown(answer, query, job.narrate));
      results_->print(written(answer, lines), job.narrate);
      if (beside_) Results("").print(lines, job.narrate);
      if (!answer.fix.accepted()) hint(input, localizer, job);
    };
    if (input.whole) {
      const Budget budget(windows_.size > 0 ? job.limits : BudgetLimits());
      answerWindow(*input.whole, {0, input.size()});
    } else {
      forEachWindow(input, windowsOf(input.size(), windows_.size, windows_.stride), job,
                    answerWindow);
    }
  }

  /// For who reads the notes, once: clouds of a batch are alike, and the search takes as long
  /// again.
  void hint(const QueryInput& input, const Localizer& localizer, const Job& job) {
    if (is_hinted_ || job.narrate.isQuiet() || job.limits.any() || !job.options.scale.empty())
      return;
    if (!input.whole || windows_.size > 0) return;
    is_hinted_ = true;
    if (const auto text = hintFor(input, input_, *map_, localizer, job)) job.narrate.note(*text);
  }

  InputFlags input_;
  WindowFlags windows_;
  VerdictFlags verdict_;
  AnswerFiles files_;
  std::string near_, yaw_, out_;
  bool json_ = false, csv_ = false, beside_ = false, is_hinted_ = false;
  Results* results_ = nullptr;  ///< of this run
  AnswerTable* table_ = nullptr;
  const map::SemanticMap* map_ = nullptr;
  Answer unanswered_;  ///< with what all answers of this run share
  std::size_t answered_ = 0, accepted_ = 0;
  std::vector<std::string> errors_;
};

}  // namespace

std::unique_ptr<Command> makeLocalize() { return std::make_unique<LocalizeCommand>(); }

}  // namespace xview::tools
