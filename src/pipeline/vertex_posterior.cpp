// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/vertex_posterior.h"

#include <algorithm>

namespace xview {
namespace {

/// Position of a frame among the poses of the query; the last one if it is not among them.
std::size_t poseOfFrame(const Query& query, std::int64_t frame) {
  const auto found = std::lower_bound(query.frames.begin(), query.frames.end(), frame);
  if (found == query.frames.end()) return query.poses.size() - 1;
  return std::min(static_cast<std::size_t>(found - query.frames.begin()), query.poses.size() - 1);
}

}  // namespace

Posterior vertexPosterior(const Query& query, const SemanticMap& map,
                          const std::vector<Correspondence>& pairs,
                          const Eigen::Isometry3d& T_map_query, const PosteriorOptions& options) {
  std::vector<MatchedVertex> matched;
  for (const Correspondence& pair : pairs) {
    const Vertex &seen = query.graph.vertices[pair.query], &known = map.graph.vertices[pair.map];
    MatchedVertex vertex;
    vertex.p_odom = seen.position;
    vertex.sigma_m = seen.sigma_m;
    vertex.first_pose = poseOfFrame(query, seen.first_frame);
    vertex.last_pose = std::max(vertex.first_pose, poseOfFrame(query, seen.last_frame));
    vertex.p_map = known.position;
    vertex.map_covariance = known.sigma_m * known.sigma_m * Eigen::Matrix3d::Identity();
    matched.push_back(vertex);
  }
  return maximizePosterior(query.poses, matched, T_map_query, options);
}

}  // namespace xview
