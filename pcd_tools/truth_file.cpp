// SPDX-License-Identifier: BSD-3-Clause
#include "truth_file.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "xview/types/error.h"

namespace xview::tools {

const Eigen::Isometry3d& Truth::poseFor(const Answer& answer) const {
  if (answer.frames == poses_.size() && answer.last_index < poses_.size())
    return poses_[answer.last_index].T_frame_sensor;
  if (const StampedPose* stamped = withStamp(answer)) return stamped->T_frame_sensor;
  const auto number = static_cast<std::size_t>(answer.last_frame);
  if (answer.last_frame >= 0 && number < poses_.size()) return poses_[number].T_frame_sensor;
  throw Error(path_, fmt::format("expected a pose of frame {} of {}, found {} poses",
                                 answer.last_frame, answer.input, poses_.size()));
}

const StampedPose* Truth::withStamp(const Answer& answer) const {
  if (answer.last_stamp_s == static_cast<double>(answer.last_index))
    return nullptr;  // a mere count
  const auto same = [&](const StampedPose& p) {
    return std::abs(p.stamp_s - answer.last_stamp_s) < 1e-4;
  };
  const auto found = std::find_if(poses_.begin(), poses_.end(), same);
  return found == poses_.end() ? nullptr : &*found;
}

}  // namespace xview::tools
