// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "xview/types/frame.h"

namespace xview::tools {

/// A recording whose odometry frame was found in another frame: the same frames with T_target_odom
/// * T_odom_sensor as poses.
class MovedRecording final : public FrameSource {
 public:
  /// The recording must outlive this object.
  MovedRecording(const FrameSource& recording, const Eigen::Isometry3d& T_target_odom)
      : recording_(recording), T_target_odom_(T_target_odom) {}

  std::size_t size() const override { return recording_.size(); }
  Eigen::Isometry3d pose(std::size_t index) const override {
    return T_target_odom_ * recording_.pose(index);
  }
  double stamp(std::size_t index) const override { return recording_.stamp(index); }
  std::int64_t number(std::size_t index) const override { return recording_.number(index); }
  Frame read(std::size_t index) const override {
    Frame frame = recording_.read(index);
    frame.T_odom_sensor = T_target_odom_ * frame.T_odom_sensor;
    return frame;
  }
  Sensor sensor() const override { return recording_.sensor(); }
  const LabelSet& labels() const override { return recording_.labels(); }
  const std::string& name() const override { return recording_.name(); }

 private:
  const FrameSource& recording_;
  Eigen::Isometry3d T_target_odom_;
};

}  // namespace xview::tools
