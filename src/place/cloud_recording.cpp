// SPDX-License-Identifier: BSD-3-Clause
#include "xview/cloud_recording.h"

#include "base/pose.h"
#include "base/stray_points.h"
#include "xview/base/error.h"

namespace xview {

CloudRecording::CloudRecording(LabelSet labels, std::string name)
    : labels_(std::move(labels)), name_(std::move(name)) {}

const Frame& CloudRecording::at(std::size_t index) const {
  if (index < frames_.size()) return frames_[index];
  throw UsageError(name_ + ": cloud " + std::to_string(index) + " of " +
                   std::to_string(frames_.size()));
}
Eigen::Isometry3d CloudRecording::pose(std::size_t index) const { return at(index).T_odom_sensor; }
double CloudRecording::stamp(std::size_t index) const { return at(index).stamp_s; }
std::int64_t CloudRecording::number(std::size_t index) const { return at(index).number; }
Frame CloudRecording::read(std::size_t index) const { return at(index); }
LeftOut CloudRecording::leftOut() const {
  LeftOut sum;
  for (const Frame& frame : frames_) {
    if (frame.cloud.left_out.any()) sum += frame.cloud.left_out;
  }
  return sum;
}
Sensor CloudRecording::sensor() const {
  return frames_.empty() ? Sensor::cloud : frames_.front().sensor;
}

void CloudRecording::requireField(bool has_label) const {
  if (labels_.empty() || has_label) return;
  throw UsageError(name_ + ": label set '" + labels_.name() +
                   "' is given, but the points have no field label");
}

void CloudRecording::append(Sensor sensor, LabelledCloud cloud,
                            const Eigen::Isometry3d& T_odom_sensor, double stamp_s) {
  const std::string place = name_ + ": cloud " + std::to_string(frames_.size());
  if (!isRigid(T_odom_sensor.matrix()))
    throw UsageError(place + ": T_odom_sensor is no rigid motion");
  leaveOutStrays(place, cloud);
  if (!frames_.empty() && sensor != frames_.front().sensor)
    throw UsageError(place + ": either all clouds of a recording have a pose, or none has");
  Frame frame;
  frame.number = static_cast<std::int64_t>(frames_.size());
  frame.stamp_s = stamp_s;
  frame.sensor = sensor;
  frame.T_odom_sensor = T_odom_sensor;
  frame.cloud = std::move(cloud);
  frames_.push_back(std::move(frame));
}

}  // namespace xview
