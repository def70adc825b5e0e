// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/pose_prior.h"

#include <algorithm>
#include <cmath>

#include "pipeline/set_verdict.h"
#include "xview/types/pose.h"
#include "xview/types/prior_text.h"

namespace xview {
namespace {

constexpr double kOtherPlace_m = 8,
                 kOtherPlace_rad = 0.4;  ///< what is farther apart is another place (samePlace)

/// Where the sensor looks in the plane: cameras along z, everything else along x. For a camera that
/// looks straight down it is what the top of its image shows.
double headingOf(const Eigen::Matrix3d& R, Sensor sensor) {
  constexpr double kStraightDown = 0.98;
  Eigen::Vector3d forward =
      R * (sensor == Sensor::camera ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitX());
  if (std::abs(forward.z()) > kStraightDown && sensor == Sensor::camera)
    forward = -(R * Eigen::Vector3d::UnitY());
  return std::atan2(forward.y(), forward.x());
}

double outsideOf(const PlacePrior::Circle& circle, const Eigen::Vector3d& p) {
  return std::hypot(p.x() - circle.x, p.y() - circle.y) - circle.radius;
}

}  // namespace

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

Priors framePriors(Priors priors, const Query& query) {
  const double last = headingOf(query.poses.back().linear(), query.sensor);
  for (PlacePrior& p : priors) {
    if (p.heading) p.heading->yaw = angleDifference(p.heading->yaw, last);
  }
  return priors;
}

bool satisfies(const Priors& priors, const Query& query, const Eigen::Isometry3d& T_map_query) {
  if (query.poses.empty()) return true;
  const Eigen::Isometry3d pose = T_map_query * query.poses.back();
  const double heading = headingOf(pose.linear(), query.sensor);
  return std::all_of(priors.begin(), priors.end(), [&](const PlacePrior& p) {
    return (!p.near || outsideOf(*p.near, pose.translation()) <= 0) &&
           (!p.heading ||
            std::abs(angleDifference(heading, p.heading->yaw)) <= p.heading->tolerance);
  });
}

bool areOnePlace(const Priors& priors) {
  return std::any_of(priors.begin(), priors.end(), [](const PlacePrior& p) {
    return p.near && p.heading && p.near->radius <= kOtherPlace_m &&
           p.heading->tolerance <= kOtherPlace_rad;
  });
}

void refuseOutside(const Priors& priors, const Query& query, Localization& answer) {
  if (!answer.accepted() || satisfies(priors, query, answer.hypotheses[0].T_map_query)) return;
  takeBack("the refined pose is outside of the prior; without it: " + answer.reason, answer);
}

}  // namespace xview
