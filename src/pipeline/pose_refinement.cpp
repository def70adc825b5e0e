// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/pose_refinement.h"

#include <algorithm>

#include "pipeline/planar_pose.h"
#include "pipeline/vertex_pairs.h"
#include "xview/types/stopwatch.h"

namespace xview {
namespace {

constexpr double kPairSigma_m = 0.5;  ///< of a pair of vertices, when nothing better is known
constexpr float kRecent_m = 20;       ///< what lies this near to the last pose has not drifted against it
constexpr double kScoreKept = 0.65;   ///< share of its score that a pose must keep when the clouds move it

PlanQuery recentPart(const PlanQuery& query, const Eigen::Vector2d& last_sensor) {
  PlanQuery recent = query;
  const Eigen::Vector2f sensor = (last_sensor - query.centre).cast<float>();
  recent.fine.erase(std::remove_if(recent.fine.begin(), recent.fine.end(),
                                   [&](const PlanQuery::Sample& s) { return (Eigen::Vector2f(s.x, s.y) - sensor).norm() > kRecent_m; }),
                    recent.fine.end());
  return recent;
}

}  // namespace

const DistributionMap& PoseRefinement::distributions() const {
  std::call_once(made_, [&] { distributions_.emplace(map_.cloud, map_.labels, options_.refine.cell_m, options_.refine.roughness_m); });
  return *distributions_;
}

/// The clouds see only some classes and take the nearest surface for the right one; what is seen from above must not contradict them.
bool PoseRefinement::looksNoWorse(const PlanQuery& recent, const Eigen::Isometry3d& before, const Eigen::Isometry3d& after) const {
  return recent.empty() || places_->score(recent, placeOf(after)) >= kScoreKept * places_->score(recent, placeOf(before));
}

void PoseRefinement::refine(const Query& query, const PlanQuery& plan_query, Localization& answer) const {
  Hypothesis& best = answer.hypotheses[0];
  const Eigen::Vector3d sensor = query.poses.back().translation();
  answer.covariance = covarianceOfPairs(answer.kept, map_.graph, best.T_map_query * sensor, kPairSigma_m);
  if (!options_.refine.enabled || query.cloud.empty() || map_.cloud.empty()) return;
  Stopwatch watch;
  const PlanQuery recent = places_ ? recentPart(plan_query, sensor.head<2>()) : PlanQuery();
  if (!recent.empty()) {
    const Eigen::Isometry3d T = poseOf(places_->verify(recent, placeOf(best.T_map_query)));
    if ((T * sensor - best.T_map_query * sensor).norm() < options_.refine.max_shift_m) best.T_map_query = T;
  }
  const Refinement refined = xview::refine(distributions(), query.cloud, query.labels, best.T_map_query, sensor, options_.refine);
  if (refined.converged && looksNoWorse(recent, best.T_map_query, refined.T_map_query)) {
    best.T_map_query = refined.T_map_query;
    answer.covariance = refined.covariance;
  }
  answer.timing_ms.emplace_back("refine", watch.lap_ms());
}

}  // namespace xview
