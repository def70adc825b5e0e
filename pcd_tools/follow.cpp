// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/core.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <optional>
#include <utility>

#include "answer_files.h"
#include "arriving_files.h"
#include "base/user_text.h"
#include "clock.h"
#include "inputs.h"
#include "io/bag_files.h"
#include "live.h"
#include "outputs.h"
#include "pose_text.h"
#include "process/atomic_file.h"
#include "tool.h"
#include "windows.h"
#include "xview/base/error.h"

namespace xview::tools {
namespace {

namespace fs = std::filesystem;

class FollowCommand final : public Command {
 public:
  Description describe() const override {
    return {"follow",
            "[FRAMES] MAP",
            "frames as they come: where is the robot after each?",
            "FRAMES: a folder that fills (--watch), any recording, or - (which is meant without "
            "FRAMES): a line PATH [stamp tx ty tz qx qy qz qw] per frame on standard input, the "
            "pose being that of the odometry. One JSON line per frame: state (searching, found, "
            "lost), pose with covariance, latency_ms. There is no pose unless it is found. Exit "
            "code 0: it was found at some time, 3: never, 1: a frame could not be read.",
            "xview follow scans/ town.xvm --watch --idle 10 --initialpose pose.yaml",
            1,
            2};
  }

  void declare(Flags& flags) override {
    input_.declareWithMap(flags);
    flags.add("--watch", watch_, "the folder FRAMES is being filled: wait for more");
    flags.add("--idle", idle_s_, "end after so long without a frame [s]; 0 = wait for ever");
    flags.add("--stop FILE", stop_, "end as soon as this file is there");
    flags.add("--window", window_,
              "most frames per query; 0 = by the sensor: one scan, or twenty images");
    flags.add("--stride", stride_, "frames from one query to the next; 0 = by the sensor");
    flags.addOutput("--initialpose", initial_pose_,
                    "file that always holds the newest pose, as YAML of "
                    "PoseWithCovarianceStamped (ROS); removed while it is lost");
    verdict_.declare(flags);
    flags.add(kSensorBaseFlag, sensor_base_, kSensorBaseHelp);
    flags.addOutput("-o,--out", out_, "file for the lines");
  }

  ExitCode run(const Job& given) override {
    checkFlags();
    if (given.operands.size() == 2 && given.operands[0] != "-") checkOrder(given.operands, input_);
    T_sensor_base_ = parseSensorBase(sensor_base_);
    requireWritable(initial_pose_);
    Job job = given;
    verdict_.applyTo(job);
    removeStale(initial_pose_, job.narrate, kUntilItIsFound);
    const map::SemanticMap map = readMap(job.operands.back(), input_, job);
    job = inMap(job, map);
    const Localizer localizer(map::borrowed(map), job.options, input_.parsed().class_names);
    Follower follower(localizer, {window_, stride_});
    Results results(out_);
    job_ = &job;
    labels_ = &map.labels;
    follower_ = &follower;
    results_ = &results;
    const std::string frames = job.operands.size() == 2 ? job.operands[0] : "-";
    if (frames == "-")
      followInput();
    else if (watch_)
      followFolder(frames);
    else
      replay(frames);
    results.finish();
    summarize();
    return failed_ > 0 ? kFailed : found_ > 0 ? kDone : kNoPose;
  }

 private:
  void checkFlags() {
    if (window_ < 0) throw UsageError(fmt::format("--window = {}, must be >= 0", window_));
    if (stride_ < 0) throw UsageError(fmt::format("--stride = {}, must be >= 0", stride_));
    if (!(idle_s_ >= 0)) throw UsageError(fmt::format("--idle = {}, must be >= 0", idle_s_));
    watch_ = watch_ || idle_s_ > 0 || !stop_.empty();
  }

  void followInput() {
    while (const auto file = nextNamed(stdin)) take(*file);
  }

  void followFolder(const std::string& folder) {
    if (!fs::is_directory(folder))
      throw Error(folder, "--watch waits for clouds in a folder, and there is none");
    FillingFolder files(folder, idle_s_, stop_);
    while (const auto file = files.next()) take(*file);
  }

  void take(const ArrivedFile& file) {
    LiveFrame frame{file.path, static_cast<std::int64_t>(latencies_ms_.size()), file.stamp_s,
                    file.T_odom_sensor.has_value()};
    Job job = *job_;
    if (frame.number > 0)
      job.narrate = Narrative(Verbosity::quiet);  // notes are those of the first
    answer(frame, [&] {
      if (!file.error.empty()) throw Error(file.error);
      return tools::follow(*follower_, openQuery(file.path, input_, job, *labels_), frame,
                           file.T_odom_sensor);
    });
  }

  /// The frames of a bag without odometry are looked for one by one.
  bool lacksOdometry(const std::string& path, std::size_t& frames) const {
    if (!io::isBag(path)) return false;
    bool has_poses = false;
    for (const io::BagTopic& topic : io::bagTopics(path, input_.parsed())) {
      has_poses |= topic.taken_as == "poses";
      if (topic.taken_as == "clouds" || topic.taken_as == "depth") frames = topic.messages;
    }
    return !has_poses;
  }

  void replayAlone(const std::string& path, std::size_t frames) {
    io::InputOptions options = input_.parsed();
    const std::size_t end = std::min(options.frames.end.value_or(frames), frames),
                      step = options.frames.step;
    Job job = *job_;
    for (std::size_t i = options.frames.begin; i < end; i += step) {
      options.frames = {i, i + 1, 1};
      const QueryInput input = openQuery(path, InputFlags(options), job, *labels_);
      job.narrate = Narrative(Verbosity::quiet);  // notes are those of the first
      LiveFrame frame{path, static_cast<std::int64_t>(i), input.source->stamp(0), false};
      answer(frame, [&] { return tools::follow(*follower_, input, frame); });
    }
  }

  void replay(const std::string& path) {
    if (!initial_pose_.empty()) T_sensor_base_ = sensorBaseOf(sensor_base_, path, input_.parsed());
    if (std::size_t frames = 0; lacksOdometry(path, frames)) return replayAlone(path, frames);
    const QueryInput input = openQuery(path, input_, *job_, *labels_);
    if (input.whole || input.size() == 1) {
      LiveFrame frame{path, 0, std::nullopt, false};
      return answer(frame, [&] { return tools::follow(*follower_, input, frame); });
    }
    const FrameSource& source = *input.source;
    for (std::size_t i = 0; i < source.size(); ++i) {
      answer({path, source.number(i), source.stamp(i), true},
             [&] { return follower_->add(source.read(i), input.labels, true); });
    }
  }

  /// A frame that cannot be used has its line, too, and the next ones are followed.
  void answer(const LiveFrame& frame, const std::function<FollowAnswer()>& follow) {
    const auto came = Clock::now();
    FollowAnswer answer;
    std::string error;
    try {
      answer = follower_->withinBudget(job_->limits, follow);
    } catch (const std::exception& e) {
      error = oneLine(e.what());
      answer = follower_->withoutPose(error);
      job_->narrate.error(error);
      ++failed_;
    }
    noteTurnedBack(frame);
    const double took_ms = 1000 * secondsSince(came);
    latencies_ms_.push_back(took_ms);
    keepInitialPose(frame, answer);
    found_ += answer.found();
    results_->print(toJson(frame, answer, took_ms, error), job_->narrate);
    if (const std::string jump = jumpText(answer); !jump.empty())
      job_->narrate.note(fmt::format("frame {}: found {}", frame.number, jump));
    if (answer.state == last_state_) return;
    job_->narrate.line(
        fmt::format("frame {}: {}: {}", frame.number, toString(answer.state), answer.reason));
    last_state_ = answer.state;
  }

  /// Once: a replay that begins anew, or two clocks.
  void noteTurnedBack(const LiveFrame& frame) {
    if (frame.stamp_s && last_stamp_s_ && *frame.stamp_s < *last_stamp_s_ && !has_turned_back_) {
      has_turned_back_ = true;
      job_->narrate.note(
          fmt::format("frame {}: its stamp {} lies before that of the frame before, {}",
                      frame.number, *frame.stamp_s, *last_stamp_s_));
    }
    if (frame.stamp_s) last_stamp_s_ = frame.stamp_s;
  }

  void keepInitialPose(const LiveFrame& frame, const FollowAnswer& answer) {
    if (initial_pose_.empty()) return;
    if (answer.found() && frame.sensor_off_m > 0 && !std::exchange(has_said_off_, true))
      job_->narrate.note(noSensorText(frame.input, frame.sensor_off_m));
    if (answer.found() && frame.sensor_off_m == 0)
      return writeFile(initial_pose_, initialPose(answer.T_map_sensor, answer.covariance,
                                                  frame.stamp_s.value_or(0), T_sensor_base_));
    if (fs::is_regular_file(initial_pose_)) fs::remove(initial_pose_);
  }

  void summarize() {
    if (latencies_ms_.empty()) return;
    const std::size_t frames = latencies_ms_.size();
    std::sort(latencies_ms_.begin(), latencies_ms_.end());
    const auto at = [&](double share) {
      return latencies_ms_[static_cast<std::size_t>(share * static_cast<double>(frames - 1))];
    };
    job_->narrate.summary(fmt::format(
        "{} frames, {} with a pose; {:.0f} ms per frame at the median, {:.0f} ms at the 99th "
        "percentile, {:.0f} ms at most",
        frames, found_, at(0.5), at(0.99), latencies_ms_.back()));
  }

  InputFlags input_;
  VerdictFlags verdict_;
  bool watch_ = false;
  double idle_s_ = 0;
  int window_ = 0, stride_ = 0;
  std::string stop_, initial_pose_, sensor_base_, out_;
  std::optional<Eigen::Isometry3d> T_sensor_base_;
  const Job* job_ = nullptr;  ///< of this run, as all that follows
  const LabelSet* labels_ = nullptr;
  Follower* follower_ = nullptr;
  Results* results_ = nullptr;
  std::vector<double> latencies_ms_;
  std::optional<double> last_stamp_s_;
  bool has_turned_back_ = false, has_said_off_ = false;
  std::size_t found_ = 0, failed_ = 0;
  FollowAnswer::State last_state_ = FollowAnswer::State::searching;
};

}  // namespace

std::unique_ptr<Command> makeFollow() { return std::make_unique<FollowCommand>(); }

}  // namespace xview::tools
