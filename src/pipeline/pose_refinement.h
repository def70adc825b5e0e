// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "pipeline/plan_registration.h"
#include "xview/localizer.h"
#include "xview/match/plan_places.h"
#include "xview/pose/refine.h"

namespace xview {

/// From the pose of the place to that of the last sensor: the older part of a window has drifted
/// against it.
class PoseRefinement {
 public:
  /// All must outlive the refinement. `places` may be null: a map without plan view.
  PoseRefinement(const SemanticMap& map, const PlanPlaces* places, const Options& options);

  /// Refines the best of at least one hypothesis and sets the covariance. `plan_query` may be
  /// empty. `up_sigma_rad` is the error of up in query and map where it was measured.
  void refine(const Query& query, const PlanQuery& plan_query, double up_sigma_rad,
              Localization& answer) const;

 private:
  bool keepsScore(const PlanQuery& recent, const Eigen::Isometry3d& before,
                  const Eigen::Isometry3d& after, double share) const;
  void useVertices(const Query& query, const PlanQuery& recent, double up_sigma_rad,
                   Localization& answer) const;
  void useRecentPart(const Query& query, const PlanQuery& recent, Localization& answer) const;
  void useClouds(const Query& query, const PlanQuery& recent, double up_sigma_rad,
                 Localization& answer) const;
  void usePlan(const Query& query, const PlanQuery& recent, double up_sigma_rad,
               Localization& answer) const;

  const SemanticMap& map_;
  const PlanPlaces* places_;
  const Options& options_;
  PlanRegistration plan_;
  std::optional<DistributionMap> distributions_;  ///< of a map with a cloud
};

}  // namespace xview
