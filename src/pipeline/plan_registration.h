// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <mutex>
#include <optional>

#include "xview/pose/refine.h"
#include "xview/types/plan_view.h"

namespace xview {

/// What lies this near to the last pose has hardly drifted against it.
constexpr double kRecent_m = 20;

/// A pose by registered plans.
struct RegisteredPlans {
  Eigen::Isometry3d T_map_query = Eigen::Isometry3d::Identity();
  std::optional<pose::Agreement> agreement;  ///< of the samples
};

/// Registers the plan views of a query and a map: their samples are surfaces, borders and objects
/// that were averaged over all frames that saw them, so they are known where no single look is,
/// from the air for one.
class PlanRegistration {
 public:
  /// The view must outlive the registration.
  explicit PlanRegistration(const PlanView& map) : map_(map) {}

  /// The pose (T_map_query) moved in the plane and about its normal to where the samples around
  /// `sensor_in_query` fit best. None if too few of them find their like. Thread-safe.
  std::optional<RegisteredPlans> align(const PlanView& query,
                                       const Eigen::Vector3d& sensor_in_query,
                                       const Eigen::Isometry3d& T_map_query) const;

 private:
  const pose::DistributionMap& distributions() const;

  const PlanView& map_;
  mutable std::once_flag made_;
  mutable std::optional<pose::DistributionMap> distributions_;  ///< made for the first query
};

}  // namespace xview
