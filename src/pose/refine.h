// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "pose/distribution_map.h"
#include "xview/base/labelled_cloud.h"
#include "xview/base/labels.h"
#include "xview/base/localization.h"
#include "xview/options.h"

namespace xview::pose {

/// The labelled points of a query and where they were seen from.
struct RefineQuery {
  const LabelledCloud& cloud;  ///< Point::view is a position in `poses`; the typical sigma of the
                               ///< points goes into the covariance
  const std::vector<Eigen::Isometry3d>&
      poses;  ///< T_query_sensor, at least one; the last is refined
};

/// Inlier ratios of points of obstacles, of those where the map holds anything, in [0, 1]. Kinds
/// are weighted by the root of their number of points, so that walls do not outweigh poles.
struct Agreement {
  double found = 0;              ///< at the pose
  double null_inlier_ratio = 0;  ///< on average some metres off
};

struct Refinement {
  bool converged = false;  ///< other fields are valid only if true
  Eigen::Isometry3d T_map_query = Eigen::Isometry3d::Identity();  ///< right for the last pose
  /// The same for every pose of the query, against the last of which the others have drifted.
  std::vector<Eigen::Isometry3d> T_map_query_at;
  /// None if the map holds next to nothing there.
  std::optional<Agreement> agreement;
  /// Of the last pose: x y z [m], rx ry rz [rad], map frame, left increment: errors of points, of
  /// drift and of single poses. An error of the map as a whole against the world is not in it.
  Matrix6d covariance = Matrix6d::Zero();
};

/// Label-aware point-to-distribution registration: minimises sum w m with m = (p - mean)^T W (p -
/// mean) over the nearest distribution of the same class, w = 1 / (1 + m / 4)^2 (Geman-McClure), by
/// Gauss-Newton about the last sensor position with a gate that narrows. Unknown are that pose and
/// the errors of the odometry at knots along the path to it; the given pose counts as one
/// observation. It is done twice: with little drift, and with that of the options from points that
/// may be far off at first. The second counts only if the points fit clearly better.
/// Where the other side of an object was mapped, a point counts a tenth. Dynamic and ignored
/// classes are left out.
Refinement refine(const DistributionMap& map, const RefineQuery& query, const LabelSet& labels,
                  const Eigen::Isometry3d& T_map_query, const RefineOptions& options);

/// Split-half self-consistency: inlier ratio of every other view of a query (of a single scan:
/// every other point) in the remaining ones as its map. Label errors lower it as they lower the
/// inlier ratio at a true pose; depth errors do not, as surfaces are thicker by them. None if there
/// are too few points.
std::optional<double> selfConsistency(const RefineQuery& query, const LabelSet& labels,
                                      const RefineOptions& options);

}  // namespace xview::pose
