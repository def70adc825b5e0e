// SPDX-License-Identifier: BSD-3-Clause
#include "xview/localizer.h"

#include <fmt/core.h>

#include <cstdio>

#include "answer.h"
#include "commands.h"
#include "explanation_files.h"
#include "queries.h"
#include "xview/io/pose_files.h"
#include "xview/types/error.h"
#include "xview/types/stopwatch.h"

namespace xview::tools {
namespace {

Answer answerFor(const QueryInput& input, const Window& window) {
  Answer answer;
  answer.input = input.path;
  answer.frames = input.size();
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

class LocalizeCommand final : public Command {
 public:
  Description describe() const override {
    return {"localize",
            "QUERY... MAP",
            "where is each query in the map?",
            "One answer per QUERY, in order: accepted, ambiguous (several places fit equally well) "
            "or rejected. With\n"
            "--window every window of frames is a query of its own. Exit code 0: all accepted, 3: "
            "not all, 1: a query\n"
            "could not be read (the others are answered all the same).",
            "xview localize town/rear --window 60 --stride 20 town.xvm",
            2,
            100000};
  }

  void declare(Flags& flags) override {
    input_.declare(flags);
    flags.add("--window", window_, "frames per query; 0 = the whole QUERY");
    flags.add("--stride", stride_, "frames between the starts of two windows; 0 = as --window");
    flags.add("--json", json_, "print one JSON object per query");
    flags.add("--explain", explain_,
              "write what speaks for and against each answer: FILE.csv and FILE.ply of one query, or "
              "a folder");
    flags.add("--tum", tum_, "write accepted poses as TUM lines to this file");
  }

  ExitCode run(const Job& job) override {
    checkWindow(window_, stride_);
    checkExplanationPath(explain_, window_ == 0 && job.operands.size() == 2);
    Stopwatch watch;
    const SemanticMap map = readMap(job.operands.back(), input_, job);
    const Localizer localizer(map, job.options);
    load_map_ms_ = watch.lap_ms();
    if (!json_) fmt::print("{}\n", tableHeading());
    for (std::size_t i = 0; i + 1 < job.operands.size(); ++i) {
      try {
        answerInput(readQuery(job.operands[i], input_, job, map.labels), localizer, job);
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

 private:
  void answerInput(const QueryInput& input, const Localizer& localizer, const Job& job) {
    for (const Window& window : windowsOf(input, window_, stride_)) {
      Answer answer = answerFor(input, window);
      answer.load_map_ms = load_map_ms_;
      const Query query = queryOf(input, window, job.options);
      answer.fix = localizer.localize(query);
      ++answered_;
      if (!explain_.empty()) {
        writeExplanation(explain_, static_cast<int>(answered_), answer,
                         localizer.explain(query, answer.fix));
      }
      if (answer.fix.accepted())
        accepted_.push_back({answer.last_stamp_s, answer.fix.T_map_sensor});
      sayHypotheses(answer, job.narrate);
      fmt::print("{}\n", json_ ? toJson(answer) : toTableLine(answer));
      std::fflush(stdout);
    }
  }

  InputFlags input_;
  int window_ = 0, stride_ = 0;
  bool json_ = false;
  std::string tum_, explain_;
  double load_map_ms_ = 0;
  std::size_t answered_ = 0, failed_ = 0;
  std::vector<StampedPose> accepted_;
};

}  // namespace

std::unique_ptr<Command> makeLocalize() { return std::make_unique<LocalizeCommand>(); }

}  // namespace xview::tools
