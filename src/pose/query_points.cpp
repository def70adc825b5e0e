// SPDX-License-Identifier: BSD-3-Clause
#include "query_points.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace xview {
namespace {

QueryPoint queryPoint(const RefineQuery& query, const LabelSet& labels, std::size_t i) {
  QueryPoint q;
  q.pose = query.poses.size() - 1;
  q.p = query.cloud.position(i);
  q.group = matchingGroup(labels, query.cloud.points[i].label);
  const std::uint32_t seen_from = query.cloud.points[i].view;
  if (seen_from == kNoView) return q;
  q.pose = std::min<std::size_t>(seen_from, query.poses.size() - 1);
  const Eigen::Vector3d view = query.poses[q.pose].translation() - q.p;
  if (view.norm() > 0) q.view = view.normalized();
  return q;
}

/// What a point tells of the place along a street, against what it misleads: most of what one sees
/// is ground, alike wherever one stands, and few things are as sharp as posts.
double worthOf(std::uint32_t group) {
  constexpr double kGround = 1.0 / 3, kPost = 3;
  const Kind kind = kindOf(group);
  return isGround(kind) ? kGround : isPoleLike(kind) ? kPost : 1;
}

/// Some of the points of every group, by number and worth, in the order of the cloud.
std::vector<std::size_t> fairShares(const std::map<std::uint32_t, std::vector<std::size_t>>& groups,
                                    int max_points) {
  double worth = 0;
  for (const auto& [group, points] : groups)
    worth += worthOf(group) * static_cast<double>(points.size());
  std::vector<std::size_t> shares;
  for (const auto& [group, points] : groups) {
    const double share = worthOf(group) * static_cast<double>(points.size()) / worth;
    const auto some = evenlySpread(points, static_cast<std::size_t>(std::ceil(max_points * share)));
    shares.insert(shares.end(), some.begin(), some.end());
  }
  std::sort(shares.begin(), shares.end());
  return shares;
}

}  // namespace

std::vector<QueryPoint> choosePoints(const RefineQuery& query, const LabelSet& labels,
                                     int max_points) {
  std::map<std::uint32_t, std::vector<std::size_t>> groups;
  for (std::size_t i = 0; i < query.cloud.size(); ++i) {
    const Point& point = query.cloud.points[i];
    const std::uint32_t group = matchingGroup(labels, point.label);
    if (group != kNoGroup && point.getVector3fMap().allFinite()) groups[group].push_back(i);
  }
  std::vector<QueryPoint> chosen;
  for (const std::size_t i : fairShares(groups, max_points))
    chosen.push_back(queryPoint(query, labels, i));
  return chosen;
}

Block blockOf(const QueryPoint& q) {
  constexpr double kBlock_m = 4;
  return {static_cast<std::int64_t>(std::floor(q.p.x() / kBlock_m)),
          static_cast<std::int64_t>(std::floor(q.p.y() / kBlock_m)), q.group};
}

std::vector<double> waysToLast(const std::vector<Eigen::Isometry3d>& poses) {
  std::vector<double> ways(poses.size(), 0);
  for (std::size_t i = poses.size() - 1; i-- > 0;)
    ways[i] = ways[i + 1] + (poses[i + 1].translation() - poses[i].translation()).norm();
  return ways;
}

}  // namespace xview
