// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/pose_refinement.h"

#include <algorithm>
#include <cmath>

#include "pipeline/plan_covariance.h"
#include "pipeline/vertex_pairs.h"
#include "pipeline/vertex_posterior.h"
#include "xview/types/stopwatch.h"

namespace xview {
namespace {

constexpr double kPairSigma_m = 0.5;  ///< of a pair of vertices, when nothing better is known
/// How far the plan seen from above leaves a pose uncertain: its samples lie about that far apart,
/// its heights are those of ground seen from afar, and the last part of a window shows its
/// direction no better.
constexpr double kPlanSigma_m = 0.25, kPlanHeightSigma_m = 0.3, kPlanYawSigma_rad = 0.01;
constexpr double kScoreKept =
    0.25;  ///< share of its score that a pose must keep when the clouds move it

double shiftOfLast(const Query& query, const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  const Eigen::Vector3d sensor = query.poses.back().translation();
  return (a * sensor - b * sensor).norm();
}

Eigen::Matrix<double, 6, 1> planVariances() {
  Eigen::Matrix<double, 6, 1> sigma;
  sigma << kPlanSigma_m, kPlanSigma_m, kPlanHeightSigma_m, 0, 0, kPlanYawSigma_rad;
  return sigma.cwiseAbs2();
}

}  // namespace

PoseRefinement::PoseRefinement(const SemanticMap& map, const Options& options)
    : map_(map), options_(options), plan_(map.plan) {
  if (!options.refine.enabled || map.cloud.empty()) return;
  std::vector<Eigen::Isometry3d> viewpoints;
  for (const Keyframe& k : map.keyframes) viewpoints.push_back(k.T_map_sensor);
  distributions_.emplace(map.cloud, map.labels, viewpoints, options.refine);
}

/// What is seen from above must not contradict the new pose.
bool PoseRefinement::keepsScore(const search::FieldQuery* recent, const Eigen::Isometry3d& before,
                                const Eigen::Isometry3d& after, double share) const {
  return !recent || recent->score(after) >= share * recent->score(before);
}

void PoseRefinement::useRecentPart(const Query& query, const search::FieldQuery* recent,
                                   Localization& answer) const {
  if (!recent) return;
  Eigen::Isometry3d& best = answer.hypotheses[0].T_map_query;
  const Eigen::Isometry3d T = recent->verify(best).T_map_query;
  if (shiftOfLast(query, T, best) < options_.refine.max_shift_m) best = T;
  answer.covariance.diagonal() += planVariances();
}

void PoseRefinement::useVertices(const Query& query, const search::FieldQuery* recent,
                                 double up_sigma_rad, Localization& answer) const {
  Eigen::Isometry3d& best = answer.hypotheses[0].T_map_query;
  PosteriorOptions options = options_.posterior;
  options.gravity_sigma_rad = std::hypot(options.gravity_sigma_rad, up_sigma_rad);
  const Posterior posterior = vertexPosterior(query, map_, answer.kept, best, options);
  if (!posterior.converged) return;
  const Eigen::Isometry3d T = posterior.T_map_sensor.back() * query.poses.back().inverse();
  if (shiftOfLast(query, T, best) >= options_.refine.max_shift_m || !keepsScore(recent, best, T, 1))
    return;
  best = T;
  answer.covariance = posterior.covariance;
}

/// The clouds take the nearest surface for the right one, and see only some classes.
void PoseRefinement::useClouds(const Query& query, const search::FieldQuery* recent,
                               double up_sigma_rad, Localization& answer) const {
  Eigen::Isometry3d& best = answer.hypotheses[0].T_map_query;
  const RefineQuery points{query.cloud, query.cloud_seen_from, query.poses, query.cloud_sigma_m};
  RefineOptions options = options_.refine;
  options.tilt_sigma_deg = std::hypot(options.tilt_sigma_deg, up_sigma_rad * 180 / M_PI);
  const Refinement refined = xview::refine(*distributions_, points, query.labels, best, options);
  if (!refined.converged || !keepsScore(recent, best, refined.T_map_query, kScoreKept)) return;
  best = refined.T_map_query;
  answer.covariance = refined.covariance;
}

/// Where single points are known too badly, their averages seen from above are left.
void PoseRefinement::usePlan(const Query& query, const search::FieldQuery* recent,
                             double up_sigma_rad, Localization& answer) const {
  Eigen::Isometry3d& best = answer.hypotheses[0].T_map_query;
  const auto T = plan_.align(query.plan, query.poses.back().translation(), best);
  if (!T || shiftOfLast(query, *T, best) >= options_.refine.max_shift_m ||
      !keepsScore(recent, best, *T, kScoreKept))
    return;
  best = *T;
  answer.covariance = registeredPlanCovariance(query, best, up_sigma_rad);
}

void PoseRefinement::refine(const Query& query, const search::FieldQuery* in_field,
                            double up_sigma_rad, Localization& answer) const {
  Stopwatch watch;
  const Eigen::Vector3d sensor = query.poses.back().translation();
  const std::unique_ptr<search::FieldQuery> near_sensor =
      in_field ? in_field->part(sensor.head<2>(), kRecent_m) : nullptr;
  const search::FieldQuery* recent =
      near_sensor && !near_sensor->empty() ? near_sensor.get() : nullptr;
  answer.covariance = covarianceOfPairs(answer.kept, map_.graph,
                                        answer.hypotheses[0].T_map_query * sensor, kPairSigma_m);
  if (options_.posterior.enabled) {
    useVertices(query, recent, up_sigma_rad, answer);
    answer.timing_ms.emplace_back("posterior", watch.lap_ms());
  }
  if (!options_.refine.enabled) return;
  useRecentPart(query, recent, answer);
  if (!query.cloud.empty() && distributions_)
    useClouds(query, recent, up_sigma_rad, answer);
  else if (recent)
    usePlan(query, recent, up_sigma_rad, answer);
  answer.timing_ms.emplace_back("refine", watch.lap_ms());
}

}  // namespace xview
