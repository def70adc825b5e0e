// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <mutex>
#include <optional>

#include "map/contents.h"
#include "pose/posterior.h"
#include "pose/refine.h"
#include "search/field.h"
#include "verdict/verdict.h"
#include "xview/base/bev_grid.h"
#include "xview/localizer.h"

namespace xview {

/// What lies this near to the last pose has hardly drifted against it.
constexpr double kRecent_m = 20;

/// A pose by registered plans.
struct RegisteredBev {
  Eigen::Isometry3d T_map_query = Eigen::Isometry3d::Identity();
  std::optional<pose::Agreement> agreement;  ///< of the samples
};

/// Registers the BEV grids of a query and a map: their samples are surfaces, borders and objects
/// that were averaged over all frames that saw them, so they are known where no single look is,
/// from the air for one.
class BevRegistration {
 public:
  /// The view must outlive the registration.
  explicit BevRegistration(const BevGrid& map)
      : alignment_(map.alignment), map_([&map]() -> auto& { return map; }) {}
  explicit BevRegistration(const map::SemanticMap& map)
      : alignment_(map.bev.alignment), map_([&map]() -> auto& { return map::viewOf(map); }) {}

  /// The pose (T_map_query) moved in the plane and about its normal to where the samples around
  /// `sensor_in_query` fit best. None if too few of them find their like. Thread-safe.
  std::optional<RegisteredBev> align(const BevGrid& query, const Eigen::Vector3d& sensor_in_query,
                                     const Eigen::Isometry3d& T_map_query) const;

 private:
  const pose::DistributionMap& distributions() const;

  Eigen::Quaterniond alignment_;
  std::function<const BevGrid&()> map_;
  mutable std::once_flag made_;
  mutable std::optional<pose::DistributionMap> distributions_;  ///< made for the first query
};

/// The best place of a query and all that is known about its pose.
struct RefinedPose {
  Eigen::Isometry3d T_map_query = Eigen::Isometry3d::Identity();
  Matrix6d covariance = Matrix6d::Zero();  ///< of the last sensor pose; see Localization
  /// Poses of the window after the posterior; empty if it did not converge.
  std::vector<Eigen::Isometry3d> T_map_sensor;
  DenseEvidence dense;
};

/// Of the points of a map, packed or not. The map must outlive them.
pose::DistributionMap distributionsOf(const map::SemanticMap& map,
                                      const pose::RefineOptions& options);

/// From the pose of the place to that of the last sensor, against which the older part of a window
/// has drifted: posterior over correspondences, the recent part of the BEV grid, and
/// registration of the clouds, or of the views where no single point is known well enough.
class PoseRefinement {
 public:
  /// All must outlive the refinement.
  PoseRefinement(const map::SemanticMap& map, const Options& options);

  /// `in_field`: the query as a field of BEV grids sees it; null if it has none.
  /// `up_sigma_rad` is the error of up in query and map where it was measured.
  RefinedPose refine(const Query& query, const search::FieldQuery* in_field,
                     const Eigen::Isometry3d& T_map_query, const std::vector<Correspondence>& kept,
                     double up_sigma_rad, Timings& timing_ms) const;

  /// See pose::selfConsistency; none for a query whose points are not registered.
  std::optional<double> selfConsistency(const Query& query) const;
  /// See pose::freeSpaceViolation.
  std::optional<double> freeSpaceViolation(const Query& query,
                                           const Eigen::Isometry3d& T_map_query) const;

 private:
  struct Step;
  void usePosterior(const std::vector<Correspondence>& kept, Step& step) const;
  void useRecentPart(Step& step) const;
  void useClouds(Step& step) const;
  void useBev(Step& step) const;

  const map::SemanticMap& map_;
  const Options& options_;
  BevRegistration bev_;
  std::optional<pose::DistributionMap> distributions_;  ///< of a map with a cloud
};

}  // namespace xview
