// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

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

/// Successive frames of a recording with other poses: those that were found for them.
class PosedRecording final : public ForwardingSource {
 public:
  /// `poses` are T_target_sensor of the frames from position `first` on. The recording must outlive
  /// this object.
  PosedRecording(const FrameSource& recording, std::size_t first,
                 std::vector<Eigen::Isometry3d> poses)
      : ForwardingSource(recording), first_(first), poses_(std::move(poses)) {}

  std::size_t size() const override { return poses_.size(); }
  Eigen::Isometry3d pose(std::size_t index) const override { return poses_.at(index); }
  double stamp(std::size_t index) const override { return ForwardingSource::stamp(first_ + index); }
  std::int64_t number(std::size_t index) const override {
    return ForwardingSource::number(first_ + index);
  }
  Frame read(std::size_t index) const override {
    Frame frame = ForwardingSource::read(first_ + index);
    frame.T_odom_sensor = poses_.at(index);
    return frame;
  }

 private:
  std::size_t first_;
  std::vector<Eigen::Isometry3d> poses_;
};

}  // namespace xview
