// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/upright_frame.h"

namespace xview {
namespace {

void turn(const Eigen::Quaterniond& R, SemanticGraph& graph, LabelledCloud& cloud) {
  for (Vertex& v : graph.vertices) v.position = R * v.position;
  const Eigen::Matrix3f turned = R.toRotationMatrix().cast<float>();
  for (pcl::PointXYZL& p : cloud.points) p.getVector3fMap() = turned * p.getVector3fMap();
  cloud.origin = R * cloud.origin;
}

}  // namespace

bool isTurned(const Eigen::Quaterniond& upright) { return upright.angularDistance(Eigen::Quaterniond::Identity()) > 0; }

std::optional<SemanticMap> uprightMap(const SemanticMap& map) {
  if (!isTurned(map.plan.upright)) return std::nullopt;
  SemanticMap turned = map;
  turn(map.plan.upright, turned.graph, turned.cloud);
  for (Keyframe& k : turned.keyframes) k.T_map_sensor = map.plan.upright * k.T_map_sensor;
  return turned;
}

Query uprightQuery(const Query& query) {
  Query turned = query;
  turn(query.plan.upright, turned.graph, turned.cloud);
  for (Eigen::Isometry3d& T : turned.poses) T = query.plan.upright * T;
  return turned;
}

void leaveUprightFrames(const Eigen::Quaterniond& map_upright, const Query& query, Localization& answer) {
  const Eigen::Isometry3d T_map_upright(map_upright.conjugate());
  for (Hypothesis& h : answer.hypotheses) h.T_map_query = T_map_upright * h.T_map_query * query.plan.upright;
  if (answer.hypotheses.empty()) return;
  answer.T_map_query = answer.hypotheses[0].T_map_query;
  answer.T_map_sensor = answer.T_map_query * query.poses.back();
  Matrix6d turned = Matrix6d::Zero();
  turned.topLeftCorner<3, 3>() = turned.bottomRightCorner<3, 3>() = T_map_upright.linear();
  answer.covariance = turned * answer.covariance * turned.transpose();
}

}  // namespace xview
