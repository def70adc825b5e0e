// SPDX-License-Identifier: BSD-3-Clause
#include "query_path.h"

#include <algorithm>
#include <cmath>

#include "xview/io/pose_files.h"

namespace xview::tools {
namespace {

/// Between two poses, straight and turning evenly.
Eigen::Isometry3d between(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double share) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::Quaterniond(a.linear())
                   .slerp(share, Eigen::Quaterniond(b.linear()))
                   .toRotationMatrix();
  T.translation() = (1 - share) * a.translation() + share * b.translation();
  return T;
}

std::vector<double> travelled(const std::vector<Eigen::Isometry3d>& poses) {
  std::vector<double> way{0};
  for (std::size_t i = 1; i < poses.size(); ++i)
    way.push_back(way.back() + (poses[i].translation() - poses[i - 1].translation()).norm());
  return way;
}

/// Grows with the root of the way.
Matrix6d odometryCovariance(double way_m, const PosteriorOptions& odometry) {
  const double root = std::sqrt(std::max(way_m, 1e-3));
  Matrix6d covariance = Matrix6d::Zero();
  covariance.diagonal().head<3>().setConstant(std::pow(odometry.odometry_sigma_m * root, 2));
  covariance.diagonal().tail<3>().setConstant(std::pow(odometry.odometry_sigma_rad * root, 2));
  return covariance;
}

}  // namespace

Eigen::Isometry3d Anchor::inMap(Eigen::Isometry3d T_odom_sensor) const {
  T_odom_sensor.translation() *= scale;
  return T_map_query * T_odom_sensor;
}

QueryPath::QueryPath(const QueryInput& input) {
  for (const FrameDigest& frame : input.frames) {
    T_odom_sensor_.push_back(frame.T_odom_sensor);
    stamps_s_.push_back(frame.stamp_s);
  }
  if (!input.frames.empty()) return;
  T_odom_sensor_ = input.whole->poses;
  for (std::size_t i = 0; i < T_odom_sensor_.size(); ++i)
    stamps_s_.push_back(static_cast<double>(i));
}

void QueryPath::add(const Answer& answer) {
  const Localization& fix = answer.fix;
  if (!fix.accepted()) return;
  const std::size_t last = T_odom_sensor_.size() - 1;
  // A graph or map is one query; its answer is that of its last pose.
  const std::size_t index = answer.frames == T_odom_sensor_.size() ? answer.last_index : last;
  anchors_.push_back(
      {index, fix.T_map_query, fix.T_map_sensor, fix.scale, fix.covariance, fix.confidence});
}

std::vector<Eigen::Isometry3d> QueryPath::poses() const {
  const std::vector<double> way = travelled(T_odom_sensor_);
  std::vector<Eigen::Isometry3d> poses;
  auto after = anchors_.begin();  // the first anchor that is not before the frame
  for (std::size_t i = 0; i < T_odom_sensor_.size(); ++i) {
    while (after != anchors_.end() && after->index < i) ++after;
    const Anchor& a = after == anchors_.begin() ? *after : *(after - 1);
    const Anchor& b = after == anchors_.end() ? *(after - 1) : *after;
    const double length = way[b.index] - way[a.index];
    const double share = length > 0 ? (way[i] - way[a.index]) / length : 1;
    poses.push_back(between(a.inMap(T_odom_sensor_[i]), b.inMap(T_odom_sensor_[i]),
                            std::clamp(share, 0.0, 1.0)));
  }
  return poses;
}

const Anchor& QueryPath::surest() const {
  return *std::max_element(anchors_.begin(), anchors_.end(), [](const Anchor& a, const Anchor& b) {
    return a.confidence < b.confidence;
  });
}

void QueryPath::writeTrajectory(const std::string& path) const {
  std::vector<StampedPose> stamped;
  for (const Eigen::Isometry3d& T : poses()) stamped.push_back({stamps_s_[stamped.size()], T});
  writeTumPoses(path, stamped);
}

void QueryPath::writeGraph(const std::string& path, const PosteriorOptions& odometry) const {
  PoseGraph graph;
  graph.poses = poses();
  graph.poses.insert(graph.poses.begin(), Eigen::Isometry3d::Identity());
  graph.fixed = {0};
  for (std::size_t i = 0; i + 1 < T_odom_sensor_.size(); ++i) {
    Eigen::Isometry3d step = T_odom_sensor_[i].inverse() * T_odom_sensor_[i + 1];
    step.translation() *= surest().scale;
    graph.edges.push_back(
        {i + 1, i + 2, step, odometryCovariance(step.translation().norm(), odometry)});
  }
  for (const Anchor& a : anchors_)
    graph.edges.push_back({0, a.index + 1, a.T_map_sensor, a.covariance});
  writePoseGraph(path, graph);
}

void QueryPath::writeTransform(const std::string& path) const {
  writeMatrix(path, surest().T_map_query, surest().scale);
}

}  // namespace xview::tools
