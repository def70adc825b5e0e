// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/vertex_pairs.h"

#include <Eigen/LU>
#include <cmath>

#include "xview/verify/sample_consensus.h"

namespace xview {
namespace {

constexpr double kVague_m = 5, kVague_rad = 0.5;

}  // namespace

std::vector<Correspondence> pairsUnderPose(const WalkGraph& query, const WalkGraph& map,
                                           const Eigen::Isometry3d& T_map_query, double reach_m) {
  const std::vector<Eigen::Vector3d> from = positionsOf(query.graph), to = positionsOf(map.graph);
  std::vector<Correspondence> near;
  for (std::uint32_t i = 0; i < from.size(); ++i) {
    const Eigen::Vector3d p = T_map_query * from[i];
    for (std::uint32_t j = 0; j < to.size(); ++j) {
      if (query.graph.vertices[i].label == map.graph.vertices[j].label &&
          (p - to[j]).squaredNorm() <= reach_m * reach_m) {
        near.push_back({i, j, 1.f});
      }
    }
  }
  std::vector<Correspondence> pairs = supporters(from, to, near, T_map_query, reach_m);
  for (Correspondence& c : pairs) c = {query.source[c.query], map.source[c.map], c.similarity};
  return pairs;
}

Matrix6d covarianceOfPairs(const std::vector<Correspondence>& pairs, const SemanticGraph& map,
                           const Eigen::Vector3d& sensor_in_map, double sigma_m) {
  Matrix6d information = Matrix6d::Zero();
  information.topLeftCorner<3, 3>().diagonal().setConstant(1 / (kVague_m * kVague_m));
  information.bottomRightCorner<3, 3>().diagonal().setConstant(1 / (kVague_rad * kVague_rad));
  for (const Correspondence& c : pairs) {
    const Eigen::Vector3d lever = map.vertices[c.map].position - sensor_in_map;
    Eigen::Matrix<double, 3, 6> J;
    J << Eigen::Matrix3d::Identity(), (Eigen::Matrix3d() << 0, lever.z(), -lever.y(), -lever.z(), 0,
                                       lever.x(), lever.y(), -lever.x(), 0)
                                          .finished();
    information += J.transpose() * J / (sigma_m * sigma_m);
  }
  return information.inverse();
}

}  // namespace xview
