// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "pipeline/pose_prior.h"
#include "pipeline/walk_proposer.h"
#include "xview/localizer.h"
#include "xview/search/search.h"

namespace xview {

/// Search over what is seen from above, then X-View descriptors inside the best place; one
/// verification for the poses of both.
class PlacePath {
 public:
  /// All must outlive the path.
  PlacePath(const WalkProposer& walks, const Options& options) : walks_(walks), options_(options) {}

  /// Fills everything but the refined pose and its covariance. `in_field` is made of query.plan.
  /// `rival_score` is that of a place elsewhere that was found otherwise.
  void localize(const Query& query, const search::FieldQuery& in_field, const Priors& priors,
                double rival_score, Localization& answer) const;
  /// The best place of a search, without a verdict; nothing if there is none.
  std::optional<search::PlaceHypothesis> bestPlace(const Query& query,
                                                   const search::FieldQuery& in_field,
                                                   const Priors& priors) const;
  /// Takes an acceptance back if a place that the priors forbid explains the query far better: then
  /// they are wrong. Only acceptances that are not clear by far are looked at.
  void refuteFromOutside(const Query& query, const search::FieldQuery& in_field,
                         const Priors& priors, Localization& answer) const;
  PoseCheck check(const Query& query, const search::FieldQuery& in_field,
                  const Eigen::Isometry3d& T_map_query, double reach_m) const;
  /// Pairs of vertices under the best of the hypotheses of an answer.
  void findPairs(const Query& query, const search::FieldQuery& in_field,
                 Localization& answer) const;

 private:
  struct RankedPlaces;
  WalkGraph mapPart(const search::FieldQuery& in_field, const Eigen::Isometry3d& T_map_query) const;
  /// By which a place is accepted that agrees in full [nats].
  double marginInFullAgreement(const Query& query) const;
  void proposeByWalks(const Query& query, const search::FieldQuery& in_field,
                      const WalkGraph& walk_query, const WalkGraph& part, const Priors& priors,
                      RankedPlaces& ranked, Localization& answer) const;
  void report(const RankedPlaces& ranked, bool from_the_air, Localization& answer) const;

  const WalkProposer& walks_;
  const Options& options_;
};

}  // namespace xview
