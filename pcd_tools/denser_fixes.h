// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "inputs.h"
#include "pose/trajectory.h"
#include "xview/localizer.h"

namespace xview::tools {

/// Where a recording was found in a map.
struct FoundFrames {
  FoundFrames() = default;
  explicit FoundFrames(std::vector<Eigen::Isometry3d> poses)
      : T_odom_sensor(std::move(poses)), is_found(T_odom_sensor.size()) {}
  /// Takes the poses of the frames of a query, whose last one is at this position of the recording:
  /// of a cloud that lies far from the origin of its frame the query has a standpoint amid it.
  void standAt(const Query& query, std::size_t last);
  /// The same of a query that was found.
  void take(const Query& query, std::size_t last);

  std::vector<Eigen::Isometry3d> T_odom_sensor;  ///< those of the recording, but for standAt()
  std::vector<pose::TrajectoryFix> fixes;        ///< in the order of the recording
  std::vector<bool> is_found;  ///< per frame: it was part of a query that was found
};

/// Adds fixes where odometry would have to be trusted for long ways: at the first frame of each
/// stretch that was found, as the last one of its way back, at the last frame of all, and every 10
/// m of a town between two fixes, where short windows are looked for near the pose that their
/// neighbours say. What is not accepted there is left to odometry.
void addFixes(const QueryInput& input, const Localizer& localizer, const Job& job,
              FoundFrames& found);

}  // namespace xview::tools
