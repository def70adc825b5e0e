// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/gravity.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <optional>

namespace xview {
namespace {

constexpr double kAligned_rad = 15 * M_PI / 180;
constexpr double kUnderSensor_m = 25;     ///< ground further away may be another slope
constexpr std::size_t kFewestPoints = 50;
constexpr double kFlatness = 0.1;         ///< thickness over width of what counts as a plane

/// Normal of the ground points of one frame, towards the sensor; nothing if they are few or no plane.
std::optional<Eigen::Vector3d> groundNormal(const FrameDigest& frame, const LabelSet& labels) {
  const float reach = frame.aerial ? INFINITY : static_cast<float>(kUnderSensor_m);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  std::size_t count = 0;
  for (std::size_t i = 0; i < frame.cloud.size(); ++i) {
    if (!isGround(labels.kind(frame.cloud.points[i].label))) continue;
    if (!frame.cloud.ranges.empty() && frame.cloud.ranges[i] > reach) continue;
    const Eigen::Vector3d p = frame.cloud.points[i].getVector3fMap().cast<double>();
    sum += p;
    squares += p * p.transpose();
    ++count;
  }
  if (count < kFewestPoints) return std::nullopt;
  const Eigen::Vector3d mean = sum / static_cast<double>(count);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(squares / static_cast<double>(count) - mean * mean.transpose());
  if (std::sqrt(std::max(0.0, axes.eigenvalues()(0))) > kFlatness * std::sqrt(axes.eigenvalues()(1))) return std::nullopt;
  const Eigen::Vector3d normal = axes.eigenvectors().col(0);
  const Eigen::Vector3d to_sensor = frame.T_odom_sensor.translation() - (frame.cloud.origin + mean);
  return normal.dot(to_sensor) < 0 ? Eigen::Vector3d(-normal) : normal;
}

}  // namespace

Eigen::Quaterniond uprightRotation(const FrameDigest* first, const FrameDigest* last, const LabelSet& labels) {
  Eigen::Vector3d up = Eigen::Vector3d::Zero(), camera_up = Eigen::Vector3d::Zero();
  for (const FrameDigest* frame = first; frame != last; ++frame) {
    if (frame->sensor == Sensor::cloud) continue;  // a saved cloud has no view-point that tells which side is up
    if (const auto normal = groundNormal(*frame, labels)) up += *normal;
    if (frame->sensor == Sensor::camera && !frame->aerial) camera_up -= frame->T_odom_sensor.linear().col(1);
  }
  if (up.norm() == 0) up = camera_up;
  if (up.norm() == 0) return Eigen::Quaterniond::Identity();
  up.normalize();
  if (std::acos(std::min(1.0, std::max(-1.0, up.z()))) < kAligned_rad) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitZ());
}

}  // namespace xview
