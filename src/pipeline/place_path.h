// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "pipeline/pose_prior.h"
#include "pipeline/walk_proposer.h"
#include "xview/localizer.h"
#include "xview/match/plan_places.h"

namespace xview {

/// Place search over plan views, then X-View descriptors inside the best place; one verification
/// for the poses of both.
class PlacePath {
 public:
  /// All must outlive the path.
  PlacePath(const PlanPlaces& places, const WalkProposer& walks, const Options& options)
      : places_(places), walks_(walks), options_(options) {}

  /// Fills everything but the refined pose and its covariance. `plan_query` is drawn from
  /// query.plan. `rival_score` is that of a place elsewhere that was found otherwise.
  void localize(const Query& query, const PlanQuery& plan_query, const Priors& priors,
                double rival_score, Localization& answer) const;
  /// The best place of a search, without a verdict; nothing if there is none.
  std::optional<PlanHypothesis> bestPlace(const Query& query, const PlanQuery& plan_query,
                                          const Priors& priors) const;
  /// Takes an acceptance back if a place that the priors forbid explains the query far better: then
  /// they are wrong. Only acceptances that are not clear by far are looked at.
  void refuteFromOutside(const Query& query, const PlanQuery& plan_query, const Priors& priors,
                         Localization& answer) const;
  PoseCheck check(const Query& query, const PlanQuery& plan_query,
                  const Eigen::Isometry3d& T_map_query, double reach_m) const;
  /// Pairs of vertices under the best of the hypotheses of an answer.
  void findPairs(const Query& query, const PlanQuery& plan_query, Localization& answer) const;

 private:
  struct RankedPlaces;
  WalkGraph mapPart(const PlanQuery& plan_query, const Eigen::Isometry3d& T_map_query) const;
  /// By which a place is accepted that agrees in full [nats].
  double marginInFullAgreement(const PlanQuery& plan_query) const;
  void proposeByWalks(const Query& query, const PlanQuery& plan_query, const WalkGraph& walk_query,
                      const WalkGraph& part, const Priors& priors, RankedPlaces& ranked,
                      Localization& answer) const;
  void report(const RankedPlaces& ranked, bool from_the_air, Localization& answer) const;

  const PlanPlaces& places_;
  const WalkProposer& walks_;
  const Options& options_;
};

}  // namespace xview
