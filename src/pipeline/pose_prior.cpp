// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/pose_prior.h"

#include <algorithm>
#include <cmath>

#include "xview/types/heading.h"
#include "xview/types/pose.h"
#include "xview/types/prior_text.h"

namespace xview {
PlacePrior parsePrior(const PriorOptions& options) {
  PlacePrior prior;
  if (!options.near.empty()) prior.near = parseCircle("prior.near", options.near);
  if (!options.yaw.empty()) prior.heading = parseHeading("prior.yaw", options.yaw);
  return prior;
}

PlacePrior priorAround(const ExpectedPose& expected, const Query& query) {
  const Eigen::Isometry3d pose = expected.T_map_query * query.poses.back();
  return {PlacePrior::Circle{pose.translation().x(), pose.translation().y(), expected.radius_m},
          PlacePrior::Heading{headingOf(pose.linear(), query.sensor), expected.yaw_rad}};
}

Priors ofQueryFrame(Priors priors, const Query& query) {
  const double of_sensor = headingOf(query.poses.back().linear(), query.sensor);
  for (PlacePrior& p : priors) {
    if (p.heading) p.heading->yaw = angleDifference(p.heading->yaw, of_sensor);
  }
  return priors;
}

bool satisfies(const Priors& priors, const Query& query, const Eigen::Isometry3d& T_map_query) {
  const Eigen::Isometry3d pose = T_map_query * query.poses.back();
  const double heading = headingOf(pose.linear(), query.sensor);
  return std::all_of(priors.begin(), priors.end(), [&](const PlacePrior& p) {
    const bool is_near =
        !p.near || std::hypot(pose.translation().x() - p.near->x,
                              pose.translation().y() - p.near->y) <= p.near->radius;
    return is_near && (!p.heading ||
                       std::abs(angleDifference(heading, p.heading->yaw)) <= p.heading->tolerance);
  });
}

}  // namespace xview
