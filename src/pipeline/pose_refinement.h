// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "pipeline/plan_registration.h"
#include "xview/localizer.h"
#include "xview/pose/refine.h"
#include "xview/search/field.h"

namespace xview {

/// From the pose of the place to that of the last sensor: the older part of a window has drifted
/// against it.
class PoseRefinement {
 public:
  /// All must outlive the refinement.
  PoseRefinement(const SemanticMap& map, const Options& options);

  /// Refines the best of at least one hypothesis and sets the covariance. `in_field` may be
  /// null: nothing was seen from above. `up_sigma_rad` is the error of up in query and map where it
  /// was measured.
  void refine(const Query& query, const search::FieldQuery* in_field, double up_sigma_rad,
              Localization& answer) const;

 private:
  bool keepsScore(const search::FieldQuery* recent, const Eigen::Isometry3d& before,
                  const Eigen::Isometry3d& after, double share) const;
  void useVertices(const Query& query, const search::FieldQuery* recent, double up_sigma_rad,
                   Localization& answer) const;
  void useRecentPart(const Query& query, const search::FieldQuery* recent,
                     Localization& answer) const;
  void useClouds(const Query& query, const search::FieldQuery* recent, double up_sigma_rad,
                 Localization& answer) const;
  void usePlan(const Query& query, const search::FieldQuery* recent, double up_sigma_rad,
               Localization& answer) const;

  const SemanticMap& map_;
  const Options& options_;
  PlanRegistration plan_;
  std::optional<DistributionMap> distributions_;  ///< of a map with a cloud
};

}  // namespace xview
