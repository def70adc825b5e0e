// SPDX-License-Identifier: BSD-3-Clause
#include "xview/localizer.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstdio>
#include <optional>

#include "answer.h"
#include "commands.h"
#include "explanation_files.h"
#include "queries.h"
#include "query_path.h"
#include "xview/io/atomic_file.h"
#include "xview/io/pose_files.h"
#include "xview/sequence.h"
#include "xview/tracker.h"
#include "xview/types/error.h"
#include "xview/types/prior_text.h"
#include "xview/types/stopwatch.h"

namespace xview::tools {
namespace {

Answer answerFor(const QueryInput& input, const Window& window) {
  Answer answer;
  answer.input = input.path;
  answer.frames = input.size();
  answer.used_from = std::max(window.first, input.used_from);
  answer.last_index = window.last - 1;
  if (!input.frames.empty()) {
    answer.first_frame = input.frames[window.first].number;
    answer.last_frame = input.frames[window.last - 1].number;
    answer.last_stamp_s = input.frames[window.last - 1].stamp_s;
  }
  return answer;
}

void sayHypotheses(const Answer& answer, const Narrative& narrate) {
  for (const Hypothesis& h : answer.fix.hypotheses) {
    const Eigen::Vector3d p = h.T_map_query.translation();
    narrate.detail(fmt::format("{}-{} {}: x {:.2f}, y {:.2f}, z {:.2f} m, score {:.1f}, {} inliers",
                               answer.first_frame, answer.last_frame, toString(h.proposer), p.x(),
                               p.y(), p.z(), h.score, h.inliers));
  }
}

void sayLost(const Answer& answer, const Narrative& narrate) {
  if (!answer.track || !answer.track->lost) return;
  narrate.stage(
      "track", 0,
      fmt::format("lost at frame {} (expected within {:.1f} m); searched everywhere: {}",
                  answer.last_frame, answer.track->radius_m, toString(answer.fix.status)));
}

/// Files that say more than one line per query; each is about one QUERY.
struct PathFiles {
  std::string trajectory, graph, matrix;

  void declare(Flags& flags) {
    flags.add("--trajectory", trajectory,
              "write all poses of the QUERY in the map frame as TUM lines to this file");
    flags.add("--g2o", graph, "write its pose graph, odometry and matches, for g2o to this file");
    flags.add("--matrix", matrix,
              "write T_map_query as four lines of four numbers to this file (CloudCompare, PDAL)");
  }
  bool any() const { return !trajectory.empty() || !graph.empty() || !matrix.empty(); }

  void write(const QueryPath& path, const Job& job) const {
    if (!any()) return;
    if (path.empty())
      return job.narrate.error("no accepted pose, so no trajectory, graph or matrix is written");
    if (!trajectory.empty()) path.writeTrajectory(trajectory);
    if (!graph.empty()) path.writeGraph(graph, job.options.posterior);
    if (!matrix.empty()) path.writeTransform(matrix);
  }
};

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
    return {"localize",
            "QUERY... MAP",
            "where is each query in the map?",
            "One answer per QUERY, in order: accepted, ambiguous (several places fit equally well) "
            "or rejected. With\n"
            "--window every window of frames is a query of its own; with --sequence what earlier "
            "windows found counts too,\n"
            "with --track the robot is followed from fix to fix. Exit code 0: all accepted, 3: not "
            "all, 1: a query\n"
            "could not be read (the others are answered all the same).",
            "xview localize town/rear --window 60 --stride 20 town.xvm",
            2,
            100000};
  }

  void declare(Flags& flags) override {
    input_.declare(flags);
    windows_.declare(flags);
    flags.add("--near", near_,
              "the last pose of each query is in the circle x,y,radius of the map [m]");
    flags.add("--yaw", yaw_,
              "it looks along heading,tolerance, counter-clockwise from x of the map [deg]");
    flags.add("--json", json_, "print one JSON object per query");
    flags.add(
        "--explain", explain_,
        "write what speaks for and against each answer: FILE.csv and FILE.ply of one query, or "
        "a folder");
    flags.add("--tum", tum_, "write accepted poses as TUM lines to this file");
    files_.declare(flags);
  }

  ExitCode run(const Job& job) override {
    const std::size_t queries = job.operands.size() - 1;
    if (!job.options.scale.empty() && (windows_.sequence || windows_.track))
      throw UsageError("--scale is for windows on their own, without --sequence and --track");
    windows_.check();
    checkExplanationPath(explain_, windows_.size == 0 && queries == 1);
    if (files_.any() && queries > 1)
      throw UsageError(
          fmt::format("--trajectory, --g2o and --matrix are for one QUERY, found {}", queries));
    for (const std::string& path : {tum_, files_.trajectory, files_.graph, files_.matrix})
      requireWritable(path);
    Job known = job;
    takePrior(known.options.prior);
    checkOrder(job.operands, input_);
    return answerAll(known);
  }

 private:
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

  ExitCode answerAll(const Job& job) {
    Stopwatch watch;
    const SemanticMap map = readMap(job.operands.back(), input_, job);
    const Localizer localizer(map, job.options);
    load_map_ms_ = watch.lap_ms();
    if (!json_) fmt::print("{}\n", tableHeading());
    for (std::size_t i = 0; i + 1 < job.operands.size(); ++i) {
      try {
        answerInput(readQuery(job.operands[i], input_, job, map.labels, windows_), localizer, job);
      } catch (const UsageError&) {
        throw;
      } catch (const std::exception& e) {
        job.narrate.error(e.what());
        ++failed_;
      }
    }
    job.narrate.stage("localize", watch.lap_ms(),
                      fmt::format("{} of {} queries accepted", accepted_.size(), answered_));
    if (!tum_.empty()) writeTumPoses(tum_, accepted_);
    if (failed_ > 0) return kFailed;
    return accepted_.size() == answered_ ? kDone : kNoPose;
  }

  void answerInput(const QueryInput& input, const Localizer& localizer, const Job& job) {
    WindowAnswers answers(localizer, windows_, job.options);
    QueryPath path(input);
    if (!input.whole && static_cast<std::size_t>(windows_.size) > input.size()) {
      job.narrate.note(fmt::format("--window {} is longer than {}: its {} frames are one query",
                                   windows_.size, input.path, input.size()));
    }
    const auto answerWindow = [&](const Query& query, const Window& window) {
      Answer answer = answerFor(input, window);
      answer.load_map_ms = load_map_ms_;
      answers.answer(query, window, answer);
      ++answered_;
      if (!explain_.empty()) {
        writeExplanation(explain_, static_cast<int>(answered_), answer,
                         localizer.explain(query, answer.fix));
      }
      if (answer.fix.accepted())
        accepted_.push_back({answer.last_stamp_s, answer.fix.T_map_sensor});
      path.add(answer);
      sayLost(answer, job.narrate);
      sayHypotheses(answer, job.narrate);
      fmt::print("{}\n", json_ ? toJson(answer) : toTableLine(answer));
      std::fflush(stdout);
    };
    forEachWindow(input, windows_, job, answerWindow);
    files_.write(path, job);
  }

  InputFlags input_;
  WindowFlags windows_;
  PathFiles files_;
  std::string near_, yaw_, tum_, explain_;
  bool json_ = false;
  double load_map_ms_ = 0;
  std::size_t answered_ = 0, failed_ = 0;
  std::vector<StampedPose> accepted_;
};

}  // namespace

std::unique_ptr<Command> makeLocalize() { return std::make_unique<LocalizeCommand>(); }

}  // namespace xview::tools
