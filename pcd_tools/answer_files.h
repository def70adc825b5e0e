// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "answer.h"
#include "denser_fixes.h"
#include "inputs.h"
#include "pose/trajectory.h"
#include "view/scene.h"
#include "xview/io/pose_files.h"
#include "xview/localizer.h"

namespace xview::tools {

/// What ros2 topic pub and a YAML reader take as geometry_msgs/PoseWithCovarianceStamped, in the
/// frame "map". `T_sensor_base`: the pose is that of the base of the robot; without it that of the
/// sensor, which a comment says.
std::string initialPose(const Eigen::Isometry3d& T_map_sensor, const Matrix6d& covariance,
                        double stamp_s, const std::optional<Eigen::Isometry3d>& T_sensor_base);

/// From where the file of a cloud puts its sensor to the nearest point, if none can have been
/// there: that is more than 10 m, and more than the cloud is long. Else 0. Of a graph things are
/// points.
double offFromSensor(const Query& query, const Eigen::Vector3d& sensor);
double offFromSensor(const LabelledCloud& cloud, const Eigen::Vector3d& sensor);
/// Why there is no file of --initialpose then.
std::string noSensorText(const std::string& input, double off_m);

/// "scan_0" of "scans/scan_0.pcd" and of "scan_0/".
std::string stemOf(const std::string& query);
/// Throws UsageError if two of them have one stem.
void requireDistinct(const std::vector<std::string>& queries);

/// The files that localize writes besides its answers.
class AnswerFiles {
 public:
  void declare(Flags& flags);
  /// With several QUERYs a file about one of them is a file of its name in a folder. Throws
  /// UsageError if two of them have one name, Error if something cannot be written.
  void check(const std::vector<std::string>& queries);

  /// Before the work: the last poses of earlier runs go, so that nobody takes one for an answer of
  /// this run. `what_else`: matrices, trajectories and TUM files as well, because it cannot answer.
  void removeOld(const std::vector<std::string>& queries, const Job& job, bool what_else);

  /// The next QUERY begins, which may turn out to be unreadable; then take() is not called.
  void begin(const std::string& query);
  void take(const QueryInput& input);
  /// Answers of one QUERY come in the order of the recording.
  void add(const Answer& answer, const Query& query, const std::function<Explanation()>& explain);
  /// After the last answer of a QUERY: finds more of its frames if its trajectory is asked for.
  void complete(const QueryInput& input, const Localizer& localizer, const Job& job);
  /// Writes what is about one QUERY: trajectory, matrix and last pose, from its accepted
  /// answers. Without one, what an earlier query left at those paths is removed.
  void end(const Job& job) const;
  /// Writes the accepted poses of all of them, for which the same holds, and the page of all
  /// explanations.
  void finish(const map::SemanticMap& map, const Job& job) const;

 private:
  /// The accepted answer that is surest; the first of equals.
  const pose::TrajectoryFix& surest() const;

  /// Where a file about this QUERY goes; empty if it was not asked for.
  std::string pathOf(const std::string& flag, const char* ending) const;
  void explain(const Answer& answer, const Query& query, const Explanation& explanation);
  void writePage(const map::SemanticMap& map, const Job& job) const;

  std::string explain_, tum_, trajectory_, matrix_, initial_pose_, sensor_base_;
  std::optional<Eigen::Isometry3d> T_sensor_base_;  ///< of this QUERY
  bool are_several_ = false;
  std::string query_;  ///< the path of this QUERY
  std::vector<double> stamps_s_;
  std::vector<pose::TrajectoryFix> fixes_;  ///< accepted answers
  double sensor_off_m_ = 0;                 ///< of the last one, from its points; 0 = is known
  FoundFrames found_;                       ///< what the trajectory goes through
  std::vector<bool> was_found_;             ///< frames of accepted queries
  std::vector<std::size_t> jumps_;          ///< of the odometry: positions of the frames behind
  std::vector<io::StampedPose> accepted_;   ///< of all of them
  std::deque<Query> explained_;             ///< those on the page, which borrows from them
  std::vector<SceneQuery> on_page_;
};

}  // namespace xview::tools
