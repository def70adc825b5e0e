// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "answer.h"
#include "xview/io/pose_files.h"

namespace xview::tools {

/// True poses of the frames of a recording, found by the rule of all poses files: one line per
/// frame, or more lines, of which line N (from 0) belongs to frame N. A real time stamp that both
/// sides have settles the second case first.
class Truth {
 public:
  explicit Truth(const std::string& path) : path_(path), poses_(readPoses(path)) {}

  /// T_map_sensor of the last frame of the query. Throws Error if the file has none.
  const Eigen::Isometry3d& poseFor(const Answer& answer) const;

 private:
  const StampedPose* withStamp(const Answer& answer) const;

  std::string path_;
  std::vector<StampedPose> poses_;
};

}  // namespace xview::tools
