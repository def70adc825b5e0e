// SPDX-License-Identifier: BSD-3-Clause
#include "place/sound_input.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "base/pose.h"
#include "xview/base/error.h"

namespace xview {

void requireNear(const std::string& name, const Eigen::Isometry3d& T, double size) {
  constexpr double kFarthest_m = 1e8;
  constexpr double kFarthestCells = 5e8;  // in canonical lengths; cells have numbers of 32 bits
  const double limit_m = std::min(kFarthest_m, kFarthestCells * size);
  if (!isRigid(T.matrix())) throw UsageError(name + " is no rigid motion");
  const double away_m = T.translation().cwiseAbs().maxCoeff();
  if (!(away_m < limit_m))
    throw UsageError(fmt::format("{} lies {:.6g} m from the origin, expected less than {:.0e} m",
                                 name, away_m, limit_m));
}

namespace {

bool areFinite(double a, double b, double c) {
  return std::isfinite(a) && std::isfinite(b) && std::isfinite(c);
}

void requireSound(const BevGrid& bev) {
  bool is_sound = bev.cell_m > 0 && std::isfinite(bev.cell_m) &&
                  areFinite(bev.origin_x, bev.origin_y, bev.origin_z) &&
                  std::abs(bev.alignment.norm() - 1) < 0.01;
  for (const std::vector<BevSample>& channel : bev.samples) {
    for (const BevSample& s : channel) is_sound = is_sound && areFinite(s.x, s.y, s.z);
  }
  for (const GroundCell& cell : bev.known) is_sound = is_sound && std::isfinite(cell.z);
  if (!is_sound) throw UsageError("the view from above of the query holds what is no number");
}

void requireSound(const LabelledCloud& cloud, std::size_t poses) {
  if (!cloud.origin.allFinite()) throw UsageError("the origin of the query's cloud is not finite");
  for (const Point& p : cloud.points) {
    if (!areFinite(p.x, p.y, p.z)) throw UsageError("a point of the query is not finite");
    if (p.view != kNoView && p.view >= poses)
      throw UsageError(
          fmt::format("a point of the query was seen from pose {} of {}", p.view, poses));
  }
}

}  // namespace

void requireSound(const SemanticGraph& graph) {
  for (const Vertex& vertex : graph.vertices) {
    if (!vertex.position.allFinite()) throw UsageError("a vertex of the graph is not finite");
  }
  if (!graph.neighbours.empty() && !isConsistent(graph))
    throw UsageError("the edges of the graph contradict its vertices; setEdges() makes them agree");
}

void requireSound(const Query& query) {
  if (query.poses.empty())
    throw UsageError("the query has no pose; makeQuery() and Localizer::query() make one that has");
  for (const Eigen::Isometry3d& T : query.poses) requireNear("a pose of the query", T, query.size);
  requireSound(query.graph);
  const bool has_lists = !query.graph.neighbours.empty() || query.graph.edge_radius_m > 0;
  if (!query.graph.empty() && !has_lists)
    throw UsageError("the graph of the query has no lists of neighbours; setEdges() makes them");
  requireSound(query.cloud, query.poses.size());
  requireSound(query.bev);
}

Eigen::Vector3d standpoint(const Eigen::Vector3d& given, const Eigen::AlignedBox3d& seen) {
  constexpr double kFar = 30;  // times the extent of what is seen
  if (seen.isEmpty() || seen.exteriorDistance(given) < kFar * seen.diagonal().norm()) return given;
  return seen.center();
}

}  // namespace xview
