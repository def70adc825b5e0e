// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "xview/localizer.h"

namespace xview {

/// What is known about a robot after one of its frames.
struct FollowAnswer {
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
  /// What the window that ends with this frame says by itself; none between windows.
  std::optional<Localization> window{};
  bool was_expected = false;     ///< the window was accepted where odometry expects it
  double expected_within_m = 0;  ///< of there, horizontally [m]; 0 = it was expected nowhere
  /// How far T_map_odom moved the robot since the last pose [m]; 0 = no farther than fixes err.
  double jump_m = 0;

  bool found() const { return state == State::found; }
};
const char* toString(FollowAnswer::State state);
const char* toString(FollowAnswer::Source source);

struct FollowOptions {
  int window = 0;  ///< most frames per query; 0 = by the sensor: each scan, or 20 images
  int stride = 0;  ///< frames from one query to the next; 0 = by the sensor: each scan, or 5 images
};

/// Follows a robot frame by frame. Windows of its last frames speak together (Sequence) until they
/// are accepted; then the next ones are looked for where odometry expects them (Tracker). Every
/// window that is not accepted there changes the odds that the robot still is where it was found:
/// they fall by the chance that somebody carried it away, and are multiplied by what the window
/// says of the place. Below the stated risk the robot is lost, as it is if its odometry jumps, if
/// frames do not fit where it is expected, or if no window was accepted for long. Between lost and
/// found there is no pose, nor with a frame that does not fit.
///
///     xview::Follower follower(localizer);
///     const auto answer = follower.add(cloud, T_odom_sensor, stamp_s);  // for every scan
class Follower {
 public:
  /// The localizer must outlive it.
  explicit Follower(const Localizer& localizer, const FollowOptions& options = {});
  explicit Follower(Localizer&&, const FollowOptions& = {}) = delete;
  Follower(Follower&&) noexcept;
  Follower& operator=(Follower&&) noexcept;
  ~Follower();

  /// The next frame. `labels`: its classes; without them they come from shapes. Without odometry
  /// every frame is a query of its own. Throws as Localizer::preprocess().
  FollowAnswer add(Frame frame, const LabelSet& labels = {}, bool has_odometry = true);
  /// The same for a scan of PCL in the frame of the sensor [m]; see CloudRecording.
  template <class PointT>
  FollowAnswer add(const pcl::PointCloud<PointT>& scan, const Eigen::Isometry3d& T_odom_sensor,
                   double stamp_s = 0, const LabelSet& labels = {}) {
    CloudRecording alone(labels);
    alone.add(scan, T_odom_sensor, stamp_s);
    return add(alone.read(0), labels);
  }
  /// A query that nothing connects with others.
  FollowAnswer add(const Query& query);
  /// What `follow`, which adds a frame, returns; no pose if its budget ends before.
  FollowAnswer withinBudget(const BudgetLimits& limits,
                            const std::function<FollowAnswer()>& follow) const;
  /// What is known of a frame that cannot be used.
  FollowAnswer withoutPose(const std::string& reason) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace xview
