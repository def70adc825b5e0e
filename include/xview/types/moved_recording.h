// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "xview/types/forwarding_source.h"

namespace xview {

/// A recording whose odometry frame was found in another frame: the same frames with
/// T_target_odom * T_odom_sensor as poses.
class MovedRecording final : public ForwardingSource {
 public:
  /// The recording must outlive this object.
  MovedRecording(const FrameSource& recording, const Eigen::Isometry3d& T_target_odom)
      : ForwardingSource(recording), T_target_odom_(T_target_odom) {}

  Eigen::Isometry3d pose(std::size_t index) const override {
    return T_target_odom_ * ForwardingSource::pose(index);
  }
  Frame read(std::size_t index) const override {
    Frame frame = ForwardingSource::read(index);
    frame.T_odom_sensor = T_target_odom_ * frame.T_odom_sensor;
    return frame;
  }

 private:
  Eigen::Isometry3d T_target_odom_;
};

}  // namespace xview
