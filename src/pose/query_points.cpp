// SPDX-License-Identifier: BSD-3-Clause
#include "query_points.h"

#include <algorithm>
#include <cmath>

namespace xview {
namespace {

QueryPoint queryPoint(const RefineQuery& query, const LabelSet& labels, std::size_t i) {
  QueryPoint q;
  q.pose = query.poses.size() - 1;
  q.p = query.cloud.position(i);
  q.group = matchingGroup(labels, query.cloud.points[i].label);
  if (query.seen_from.size() != query.cloud.size()) return q;
  q.pose = std::min<std::size_t>(query.seen_from[i], query.poses.size() - 1);
  const Eigen::Vector3d view = query.poses[q.pose].translation() - q.p;
  if (view.norm() > 0) q.view = view.normalized();
  return q;
}

}  // namespace

std::vector<QueryPoint> choosePoints(const RefineQuery& query, const LabelSet& labels,
                                     int max_points) {
  std::vector<std::size_t> usable;
  for (std::size_t i = 0; i < query.cloud.size(); ++i) {
    const pcl::PointXYZL& point = query.cloud.points[i];
    if (matchingGroup(labels, point.label) != kNoGroup && point.getVector3fMap().allFinite())
      usable.push_back(i);
  }
  std::vector<QueryPoint> chosen;
  for (const std::size_t i : evenlySpread(usable, static_cast<std::size_t>(max_points)))
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
