// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "inputs.h"
#include "xview/localizer.h"
#include "xview/pose/trajectory.h"

namespace xview::tools {

/// Half-open range of positions in QueryInput::frames.
struct Window {
  std::size_t first = 0;
  std::size_t last = 0;
};

/// Calls take(query, window) for windows of a recording, which are in order. It is digested once,
/// whatever the windows share, and no more of it is kept than the next window needs.
void forEachWindow(const QueryInput& input, const std::vector<Window>& windows, const Job& job,
                   const std::function<void(const Query&, const Window&)>& take);

/// A recording that was found in a map all along its way.
struct PlacedRecording {
  std::vector<pose::TrajectoryFix> fixes;  ///< of the windows that were accepted
  std::size_t windows = 0;                 ///< that were asked
  /// Positions of the frames that lie in accepted windows or between them, half-open.
  std::size_t first = 0, last = 0;
  std::vector<Eigen::Isometry3d> T_map_sensor;  ///< of these frames
  double sigma_m = 0;                           ///< of the position of a fix, the median
  std::string reason;                           ///< of the last window that was not accepted
};

/// Finds a recording by windows of some 60 m of a town that overlap by half and speak together, and
/// bends its odometry through them, because it drifts. `fixes` is empty if none was accepted.
PlacedRecording placeRecording(const QueryInput& input, const Localizer& localizer, const Job& job);

}  // namespace xview::tools
