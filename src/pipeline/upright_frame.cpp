// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/upright_frame.h"

namespace xview {
namespace {

bool isTurn(const Eigen::Quaterniond& upright) {
  return upright.angularDistance(Eigen::Quaterniond::Identity()) > 0;
}

/// The plan stays where it is: another turn leads to it.
void turn(const Eigen::Quaterniond& R, SemanticGraph& graph, LabelledCloud& cloud, PlanView& plan) {
  for (Vertex& v : graph.vertices) v.position = R * v.position;
  const Eigen::Matrix3f turned = R.toRotationMatrix().cast<float>();
  for (Point& p : cloud.points) p.getVector3fMap() = turned * p.getVector3fMap();
  cloud.origin = R * cloud.origin;
  plan.upright = plan.upright * R.conjugate();
}

}  // namespace

std::optional<SemanticMap> uprightMap(const SemanticMap& map, const Eigen::Quaterniond& upright) {
  if (!isTurn(upright)) return std::nullopt;
  SemanticMap turned = map;
  turn(upright, turned.graph, turned.cloud, turned.plan);
  for (Keyframe& k : turned.keyframes) k.T_map_sensor = upright * k.T_map_sensor;
  return turned;
}

Query uprightQuery(const Query& query, const Eigen::Quaterniond& upright) {
  Query turned = query;
  turn(upright, turned.graph, turned.cloud, turned.plan);
  for (Eigen::Isometry3d& T : turned.poses) T = upright * T;
  return turned;
}

UprightQuery::UprightQuery(const Query& given, const Eigen::Quaterniond& upright)
    : turned(isTurn(upright) ? std::optional(uprightQuery(given, upright)) : std::nullopt),
      query(turned ? *turned : given) {}

void leaveUprightFrames(const Eigen::Quaterniond& map_upright,
                        const Eigen::Quaterniond& query_upright, const Query& query,
                        Localization& answer) {
  const Eigen::Isometry3d T_map_upright(map_upright.conjugate());
  for (Hypothesis& h : answer.hypotheses)
    h.T_map_query = T_map_upright * h.T_map_query * query_upright;
  if (answer.hypotheses.empty()) return;
  answer.T_map_query = answer.hypotheses[0].T_map_query;
  answer.T_map_sensor = answer.T_map_query * query.poses.back();
  Matrix6d turned = Matrix6d::Zero();
  turned.topLeftCorner<3, 3>() = turned.bottomRightCorner<3, 3>() = T_map_upright.linear();
  answer.covariance = turned * answer.covariance * turned.transpose();
}

}  // namespace xview
