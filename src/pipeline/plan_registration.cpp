// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/plan_registration.h"

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "xview/types/labelled_cloud.h"
#include "xview/types/labels.h"
#include "xview/types/pose.h"

namespace xview {
namespace {

/// Four cells of a plan view in a distribution. Samples err by about half a cell; of tilt the plan
/// knows nothing.
pose::RefineOptions planRefinement() {
  pose::RefineOptions options;
  options.cell_m = 2;
  options.model.roughness_m = 0.3;
  options.model.first_gate_m = 1.5;
  options.model.last_gate_m = 1.2;
  options.tilt_sigma_deg = 0.01;
  options.model.drift_share = 0;
  options.model.start_reach_m = 0;
  return options;
}

/// Every channel is a class that matches itself only.
LabelSet channelClasses() {
  LabelSet classes("channels");
  for (std::size_t c = 0; c < kChannels; ++c) {
    ClassInfo info;
    info.id = static_cast<std::uint32_t>(c);
    info.name = toString(static_cast<Channel>(c));
    info.role = Role::surface;
    info.kind = Kind::other_surface;
    classes.add(info);
  }
  return classes;
}

/// Samples at height 0. Areas are left out: their borders are channels of their own, and where an
/// area ends without one nothing more was seen.
LabelledCloud flatCloud(const PlanView& view, const Eigen::Vector2d& centre, double reach_m) {
  LabelledCloud cloud;
  cloud.origin = {view.origin_x, view.origin_y, 0};
  const Eigen::Vector2d from_origin = centre - cloud.origin.head<2>();
  for (std::size_t c = 0; c < kChannels; ++c) {
    if (isArea(static_cast<Channel>(c))) continue;
    for (const PlanSample& s : view.samples[c]) {
      if ((Eigen::Vector2d(s.x, s.y) - from_origin).norm() <= reach_m)
        cloud.points.emplace_back(s.x, s.y, 0.F, static_cast<std::uint32_t>(c));
    }
  }
  return cloud;
}

/// Its part in the plane: position and direction.
Eigen::Isometry3d planarPart(const Eigen::Isometry3d& T) {
  return poseFromYaw({T.translation().x(), T.translation().y(), 0}, yawOf(T.linear()));
}

}  // namespace

const pose::DistributionMap& PlanRegistration::distributions() const {
  std::call_once(made_, [&] {
    distributions_.emplace(
        flatCloud(map_, Eigen::Vector2d::Zero(), std::numeric_limits<double>::infinity()),
        channelClasses(), std::vector<Eigen::Isometry3d>(), planRefinement());
  });
  return *distributions_;
}

std::optional<RegisteredPlans> PlanRegistration::align(const PlanView& query,
                                                       const Eigen::Vector3d& sensor_in_query,
                                                       const Eigen::Isometry3d& T_map_query) const {
  const Eigen::Isometry3d up_of_map(map_.upright), up_of_query(query.upright);
  const Eigen::Isometry3d before = planarPart(up_of_map * T_map_query * up_of_query.inverse());
  Eigen::Isometry3d sensor = Eigen::Isometry3d::Identity();
  sensor.translation().head<2>() = (up_of_query * sensor_in_query).head<2>();
  const LabelledCloud cloud = flatCloud(query, sensor.translation().head<2>(), kRecent_m);
  const std::vector<Eigen::Isometry3d> poses{sensor};
  const pose::Refinement found =
      pose::refine(distributions(), pose::RefineQuery{cloud, poses},
                   channelClasses(), before, planRefinement());
  if (!found.converged) return std::nullopt;
  const Eigen::Isometry3d motion = planarPart(found.T_map_query) * before.inverse();
  return RegisteredPlans{up_of_map.inverse() * motion * up_of_map * T_map_query, found.overlap};
}

}  // namespace xview
