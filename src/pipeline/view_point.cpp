// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/view_point.h"

namespace xview {
namespace {

/// What the query shows, horizontally; of bare graphs the vertices.
Eigen::AlignedBox2d boxOf(const Query& query) {
  Eigen::AlignedBox2d box;
  for (std::size_t i = 0; i < query.cloud.size(); ++i)
    box.extend(query.cloud.position(i).head<2>());
  for (const Vertex& vertex : query.graph.vertices) box.extend(vertex.position.head<2>());
  return box;
}

Eigen::Vector3d centreOf(const SemanticGraph& graph) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Vertex& vertex : graph.vertices) sum += vertex.position;
  return sum / static_cast<double>(graph.size());
}

Eigen::Matrix3d cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

}  // namespace

std::optional<Query> seenFromItsCentre(const Query& query) {
  if (query.sensor != Sensor::cloud || query.poses.size() != 1 || query.graph.empty())
    return std::nullopt;
  if (boxOf(query).contains(query.poses[0].translation().head<2>())) return std::nullopt;
  Query centred = query;
  centred.poses = {Eigen::Isometry3d(Eigen::Translation3d(centreOf(query.graph)))};
  return centred;
}

Matrix6d movedCovariance(const Matrix6d& covariance, const Eigen::Vector3d& p_map,
                         const Eigen::Vector3d& to_map) {
  // d(to) = d(p) + d(theta) x (to - p)
  Matrix6d J = Matrix6d::Identity();
  J.topRightCorner<3, 3>() = -cross(to_map - p_map);
  return J * covariance * J.transpose();
}

}  // namespace xview
