// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "pipeline/walk_proposer.h"
#include "xview/localizer.h"
#include "xview/match/plan_places.h"
#include "xview/types/place.h"

namespace xview {

/// Place search over plan views, then X-View descriptors inside the best place; one verification for the poses of both.
class PlacePath {
 public:
  /// All must outlive the path.
  PlacePath(const PlanPlaces& places, const WalkProposer& walks, const PlacePrior& prior, const Options& options)
      : places_(places), walks_(walks), prior_(prior), options_(options) {}

  /// Fills everything but the refined pose and its covariance. `plan_query` is drawn from query.plan.
  void localize(const Query& query, const PlanQuery& plan_query, Localization& answer) const;

 private:
  struct RankedPlaces;
  void proposeByWalks(const Query& query, const PlanQuery& plan_query, const WalkGraph& walk_query, const WalkGraph& part,
                      RankedPlaces& ranked, Localization& answer) const;
  void report(const RankedPlaces& ranked, bool from_the_air, Localization& answer) const;

  const PlanPlaces& places_;
  const WalkProposer& walks_;
  const PlacePrior& prior_;
  const Options& options_;
};

}  // namespace xview
