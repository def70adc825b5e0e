// SPDX-License-Identifier: BSD-3-Clause
#include "xview/follower.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "base/median.h"
#include "localizer/tracker.h"
#include "place/shapes.h"
#include "pose/trajectory.h"
#include "xview/sequence.h"

namespace xview {
namespace {

using Source = FollowAnswer::Source;
using Stage = FollowAnswer::State;

constexpr int kScanWindow = 1, kImageWindow = 20, kImageStride = 5;
/// Chance that somebody carried the robot away from one window to the next. At the usual risk a
/// window that is not accepted must at least speak for the place.
constexpr double kCarriedAway = 0.01;
/// Path length over which odometry is believed without an accepted window [m in a town].
constexpr double kBlind_m = 20;
/// Least share of the score expected at the true pose with which a frame fits.
constexpr double kLeastShare = 0.5;
constexpr double kReach_m = 1.5;      ///< radius in which that pose is sought [m in a town]
constexpr int kMostFailedChecks = 2;  ///< frames in a row that do not fit and lose the robot
/// Least step of the odometry that is a jump [m in a town], and least multiple of the median step.
constexpr double kJump_m = 3, kJumpSteps = 8;
constexpr std::size_t kUsualSteps = 16;
constexpr const char* kDoesNotFit = "the frame does not fit where it is expected";

double logOdds(double p) {
  const double bounded = std::clamp(p, 1e-6, 1 - 1e-6);
  return std::log(bounded / (1 - bounded));
}
double chanceOf(double log_odds) { return 1 / (1 + std::exp(-log_odds)); }

}  // namespace

const char* toString(FollowAnswer::State state) {
  return state == Stage::found ? "found" : state == Stage::lost ? "lost" : "searching";
}

const char* toString(FollowAnswer::Source source) {
  return source == Source::fix ? "fix" : source == Source::held ? "held" : "odometry";
}

struct Follower::State {
  State(const Localizer& localizer, const FollowOptions& options)
      : localizer_(localizer),
        options_(localizer.options()),
        window_(options.window),
        stride_(options.stride) {}

  FollowAnswer add(Frame frame, const LabelSet& given, bool has_odometry);
  FollowAnswer add(const Query& query);
  FollowAnswer withoutPose(const std::string& reason) const;
  bool takeStep(const Eigen::Isometry3d& T_odom_sensor);
  void lose();
  FollowAnswer between() const;
  FollowAnswer judge(const Query& query);
  FollowAnswer searched(const Query& query);
  FollowAnswer found(const Localization& fix);
  FollowAnswer predicted(FollowAnswer::Source source, std::string reason) const;
  bool newestFits() const;
  bool isBlind() const;
  FollowAnswer withWindow(FollowAnswer answer) {
    answer.window = std::exchange(window_answer_, std::nullopt);
    answer.was_expected = std::exchange(was_expected_, false);
    answer.expected_within_m = std::exchange(expected_within_m_, 0);
    return answer;
  }

  struct Fix {
    Eigen::Isometry3d T_map_odom, T_map_sensor;
    Matrix6d covariance;
    double log_odds;     ///< that the robot is there
    double travelled_m;  ///< since the last accepted window
  };

  const Localizer& localizer_;
  const Options& options_;
  int window_, stride_;
  std::optional<Sequence> sequence_;  ///< while it is searched for, if poses have scores
  std::optional<Tracker> tracker_;    ///< while it is found
  std::optional<Fix> fix_;            ///< while it is found
  LabelSet labels_;
  std::deque<PreprocessedFrame> frames_;  ///< of the next window
  std::size_t taken_ = 0;                 ///< frames so far
  int since_window_ = 0;
  int failed_checks_ = 0;  ///< frames in a row that do not fit
  bool was_found_ = false;
  std::optional<Eigen::Isometry3d> T_map_odom_;  ///< of the last fix, also while it is lost
  std::optional<Localization> window_answer_;    ///< of the last window, until it is handed out
  bool was_expected_ = false;
  double expected_within_m_ = 0;
  std::optional<Eigen::Isometry3d> last_;  ///< T_odom_sensor
  std::deque<double> steps_m_;             ///< of the last frames
};

FollowAnswer Follower::State::withoutPose(const std::string& reason) const {
  FollowAnswer answer;
  answer.state = was_found_ ? Stage::lost : Stage::searching;
  answer.reason = reason;
  return answer;
}

/// True if the odometry jumps.
bool Follower::State::takeStep(const Eigen::Isometry3d& T_odom_sensor) {
  const auto before = std::exchange(last_, T_odom_sensor);
  if (!before) return false;
  const double step_m = (T_odom_sensor.translation() - before->translation()).norm();
  const bool is_usual =
      steps_m_.empty() ||
      step_m <= kJumpSteps * medianOf(std::vector<double>(steps_m_.begin(), steps_m_.end()));
  if (step_m > kJump_m * localizer_.size() && !is_usual) {
    steps_m_.clear();
    return true;
  }
  steps_m_.push_back(step_m);
  if (steps_m_.size() > kUsualSteps) steps_m_.pop_front();
  if (fix_) fix_->travelled_m += step_m;
  return false;
}

/// What was seen before says nothing of where it is now.
void Follower::State::lose() {
  fix_.reset();
  tracker_.reset();
  sequence_.reset();
  failed_checks_ = 0;
}

FollowAnswer Follower::State::add(Frame frame, const LabelSet& given, bool has_odometry) {
  if (window_ == 0) window_ = frame.sensor == Sensor::camera ? kImageWindow : kScanWindow;
  if (stride_ == 0) stride_ = frame.sensor == Sensor::camera ? std::min(kImageStride, window_) : 1;
  const Eigen::Isometry3d T_odom_sensor = frame.T_odom_sensor;
  const bool is_labelled = !given.empty();
  const LabelSet labels = is_labelled ? given : labelsOfShapes();
  PreprocessedFrame preprocessed = is_labelled ? preprocessFrame(std::move(frame), labels, options_)
                                               : localizer_.preprocess(frame);
  if (!has_odometry) return add(makeQuery(&preprocessed, &preprocessed + 1, labels, options_));
  const bool jumps = takeStep(T_odom_sensor);
  if (jumps) lose();
  if (jumps || !(labels == labels_)) {
    frames_.clear();
    since_window_ = 0;
    labels_ = labels;
  }
  frames_.push_back(std::move(preprocessed));
  if (frames_.size() > static_cast<std::size_t>(window_)) frames_.pop_front();
  ++taken_;
  ++since_window_;
  failed_checks_ = newestFits() ? 0 : failed_checks_ + 1;
  if (failed_checks_ > 0 && failed_checks_ < kMostFailedChecks) return withoutPose(kDoesNotFit);
  if (failed_checks_ > 0) {
    lose();
    frames_.erase(frames_.begin(), frames_.end() - kMostFailedChecks);
  }
  if (since_window_ < stride_) return jumps ? withoutPose("the odometry jumps") : between();
  since_window_ = 0;
  const std::vector<PreprocessedFrame> window(frames_.begin(), frames_.end());
  const Query query = makeQuery(window.data(), window.data() + window.size(), labels, options_);
  if (!query.jumps.empty()) {
    lose();
    frames_.erase(frames_.begin(),
                  frames_.begin() + static_cast<std::ptrdiff_t>(query.jumps.back().position));
  }
  return judge(query);
}

/// Of several frames most may still be those of before it was carried away, so the newest is asked
/// by itself.
bool Follower::State::newestFits() const {
  if (!fix_ || window_ == 1 || !localizer_.scoresPoses()) return true;
  const PreprocessedFrame& newest = frames_.back();
  const PlaceEvidence seen =
      localizer_
          .check(makeQuery(&newest, &newest + 1, labels_, options_), {fix_->T_map_odom},
                 kReach_m * localizer_.size() + options_.odometry.drift * fix_->travelled_m)[0]
          .evidence;
  return seen.score >= kLeastShare * seen.expected &&
         seen.obstacles.score >= kLeastShare * seen.obstacles.expected;
}

FollowAnswer Follower::State::add(const Query& query) {
  lose();
  frames_.clear();
  last_.reset();
  T_map_odom_.reset();
  const Localization fix = localizer_.localize(query);
  window_answer_ = fix;
  if (!fix.accepted()) return withoutPose(fix.reason);
  was_found_ = true;
  return {Stage::found,   Source::fix,    fix.T_map_sensor, fix.T_map_query,
          fix.covariance, fix.confidence, fix.reason};
}

bool Follower::State::isBlind() const { return fix_->travelled_m > kBlind_m * localizer_.size(); }

FollowAnswer Follower::State::between() const {
  if (!fix_) return withoutPose("frames are gathered for the next window");
  const std::string way =
      fmt::format("{:.2f} m of odometry since the last accepted window", fix_->travelled_m);
  return isBlind() ? withoutPose(way) : predicted(Source::odometry, way);
}

/// The odometry adds its own errors, and the lever those of the heading.
FollowAnswer Follower::State::predicted(Source source, std::string reason) const {
  FollowAnswer answer{Stage::found,     source,           fix_->T_map_odom * *last_,
                      fix_->T_map_odom, fix_->covariance, chanceOf(fix_->log_odds),
                      std::move(reason)};
  answer.covariance = pose::movedCovariance(fix_->covariance, fix_->T_map_sensor.translation(),
                                            answer.T_map_sensor.translation());
  const double drift_m = options_.odometry.drift * fix_->travelled_m;
  const double drift_rad = options_.odometry.drift_deg_per_m * M_PI / 180 * fix_->travelled_m;
  for (int i = 0; i < 3; ++i) answer.covariance(i, i) += drift_m * drift_m;
  answer.covariance(5, 5) += drift_rad * drift_rad;
  return answer;
}

FollowAnswer Follower::State::found(const Localization& fix) {
  fix_ = Fix{fix.T_map_sensor * last_->inverse(), fix.T_map_sensor, fix.covariance,
             logOdds(fix.confidence), 0};
  was_found_ = true;
  FollowAnswer answer = predicted(Source::fix, fix.reason);
  if (const auto before = std::exchange(T_map_odom_, fix_->T_map_odom)) {
    const double moved_m =
        ((*before * *last_).translation() - answer.T_map_sensor.translation()).norm();
    if (moved_m > kJump_m * localizer_.size()) answer.jump_m = moved_m;
  }
  return answer;
}

/// One step of a sequential test between "still there" and "elsewhere".
FollowAnswer Follower::State::judge(const Query& query) {
  if (!fix_) return searched(query);
  const TrackAnswer answer = tracker_->follow(query);
  window_answer_ = answer.fix;
  was_expected_ = answer.local;
  expected_within_m_ = answer.radius_m;
  if (answer.fix.accepted()) return found(answer.fix);
  if (isBudgetSpent()) return withoutPose(answer.fix.reason);
  const Eigen::Vector3d expected = (fix_->T_map_odom * *last_).translation();
  const bool is_there =
      !answer.fix.hypotheses.empty() &&
      (answer.fix.T_map_sensor.translation() - expected).norm() <= answer.radius_m;
  fix_->log_odds = logOdds(chanceOf(fix_->log_odds) * (1 - kCarriedAway)) +
                   logOdds(is_there ? answer.fix.confidence : 0);
  const double chance = chanceOf(fix_->log_odds);
  if (chance >= options_.verdict.min_confidence && !isBlind())
    return predicted(Source::held, fmt::format("with what was known before {:.4f}; by itself {}",
                                               chance, answer.fix.reason));
  lose();
  return withoutPose("not where it was expected; " + answer.fix.reason);
}

FollowAnswer Follower::State::searched(const Query& query) {
  Localization fix;
  if (!localizer_.scoresPoses()) {
    fix = localizer_.localize(query);
  } else {
    if (!sequence_) sequence_.emplace(localizer_, options_);
    fix = sequence_->add(query, taken_ - frames_.size(), taken_).fix;
  }
  window_answer_ = fix;
  if (!fix.accepted()) return withoutPose(fix.reason);
  sequence_.reset();
  tracker_.emplace(localizer_, options_);
  tracker_->begin(query, fix);
  const auto before = T_map_odom_;
  const FollowAnswer answer = found(fix);
  // If the robot was carried away in between, most frames of the window are those of before.
  failed_checks_ = newestFits() ? 0 : 1;
  if (failed_checks_ == 0) return answer;
  T_map_odom_ = before;  // nobody was told
  return withoutPose(kDoesNotFit);
}

Follower::Follower(const Localizer& localizer, const FollowOptions& options)
    : state_(std::make_unique<State>(localizer, options)) {}
Follower::Follower(Follower&&) noexcept = default;
Follower& Follower::operator=(Follower&&) noexcept = default;
Follower::~Follower() = default;

FollowAnswer Follower::add(Frame frame, const LabelSet& labels, bool has_odometry) {
  return state_->withWindow(state_->add(std::move(frame), labels, has_odometry));
}

FollowAnswer Follower::add(const Query& query) { return state_->withWindow(state_->add(query)); }

FollowAnswer Follower::withoutPose(const std::string& reason) const {
  return state_->withoutPose(reason);
}

FollowAnswer Follower::withinBudget(const BudgetLimits& limits,
                                    const std::function<FollowAnswer()>& follow) const {
  const Budget budget(limits);
  FollowAnswer answer;
  if (const auto cut = cutByBudget([&] { answer = follow(); })) answer = withoutPose(cut->reason);
  answer.budget_exhausted = budget.exhausted();
  return answer;
}

}  // namespace xview
