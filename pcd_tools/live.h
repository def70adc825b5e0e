// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>

#include "inputs.h"
#include "xview/sequence.h"
#include "xview/tracker.h"

namespace xview::tools {

/// What is known about a robot after one of its frames.
struct LiveAnswer {
  enum class State {
    searching,  ///< never found so far
    found,      ///< the pose is right but for the stated risk
    lost        ///< it was found once; nothing is said of the pose until it is found again
  };
  enum class Source {
    fix,      ///< the window that ends with this frame was accepted
    held,     ///< the window by itself is too weak, with what was known before it is not
    odometry  ///< no window ends with this frame: odometry since the last one
  };
  State state = State::searching;
  Source source = Source::fix;                                     ///< as all that follows if found
  Eigen::Isometry3d T_map_sensor = Eigen::Isometry3d::Identity();  ///< [m]
  Eigen::Isometry3d T_map_odom = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Zero();  ///< of T_map_sensor, as in Localization
  double confidence = 0;                   ///< chance that the pose is right, in [0, 1]
  std::string reason;
  std::string budget_exhausted{};  ///< Budget::exhausted()

  bool found() const { return state == State::found; }
};
const char* toString(LiveAnswer::State state);

/// A frame as it comes.
struct LiveFrame {
  std::string input;  ///< what messages call it
  std::int64_t number = 0;
  std::optional<double> stamp_s;
  bool has_odometry = false;  ///< else every frame is a query of its own
};

/// One JSON object on one line; pose, covariance and T_map_odom are null unless the robot is found.
/// `error`: why the frame could not be used.
std::string toJson(const LiveFrame& frame, const LiveAnswer& answer, double latency_ms,
                   const std::string& error = {});

/// Follows a robot frame by frame. Windows of its last frames speak together (Sequence) until they
/// are accepted; then the next ones are looked for where odometry expects them (Tracker). Every
/// window that is not accepted there changes the odds that the robot still is where it was found:
/// they fall by the chance that somebody carried it away, and are multiplied by what the window
/// says of the place. Below the stated risk the robot is lost, as it is if its odometry jumps, if
/// frames do not fit where it is expected, or if no window was accepted for long. Between lost and
/// found there is no pose, nor with a frame that does not fit.
class Follower {
 public:
  /// The localizer must outlive it. `window`, `stride`: most frames per query, and from one to the
  /// next; 0 = by the sensor: each scan, or 20 images, every 5.
  Follower(const Localizer& localizer, const Options& options, int window, int stride);

  /// The next frame. `pose`: that of the odometry, if it is not in the input. Throws Error if the
  /// input is no frame, and as preprocessFrame().
  LiveAnswer add(const QueryInput& input, const LiveFrame& about,
                 const std::optional<Eigen::Isometry3d>& T_odom_sensor = {});
  /// The same for a frame that was read.
  LiveAnswer add(Frame frame, const LabelSet& labels, bool has_odometry);
  /// What `follow`, which adds a frame, returns; no pose if its budget ends before.
  LiveAnswer withinBudget(const BudgetLimits& limits,
                          const std::function<LiveAnswer()>& follow) const;
  /// What is known of a frame that cannot be used.
  LiveAnswer withoutPose(const std::string& reason) const;

 private:
  bool takeStep(const Eigen::Isometry3d& T_odom_sensor);
  void lose();
  LiveAnswer alone(const Query& query);
  LiveAnswer between() const;
  LiveAnswer judge(const Query& query);
  LiveAnswer searched(const Query& query);
  LiveAnswer found(const Localization& fix);
  LiveAnswer predicted(LiveAnswer::Source source, std::string reason) const;
  bool newestFits() const;
  bool isBlind() const;

  struct Fix {
    Eigen::Isometry3d T_map_odom, T_map_sensor;
    Matrix6d covariance;
    double log_odds;     ///< that the robot is there
    double travelled_m;  ///< since the last accepted window
  };

  const Localizer& localizer_;
  const Options options_;
  int window_, stride_;
  std::optional<Sequence> sequence_;  ///< while it is searched for, but with method walks
  std::optional<Tracker> tracker_;    ///< while it is found
  std::optional<Fix> fix_;            ///< while it is found
  LabelSet labels_;
  std::deque<PreprocessedFrame> frames_;  ///< of the next window
  std::size_t taken_ = 0;                 ///< frames so far
  int since_window_ = 0;
  int failed_checks_ = 0;  ///< frames in a row that do not fit
  bool was_found_ = false;
  std::optional<Eigen::Isometry3d> last_;  ///< T_odom_sensor
  std::deque<double> steps_m_;             ///< of the last frames
};

}  // namespace xview::tools
