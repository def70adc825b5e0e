// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <vector>

#include "xview/types/labelled_cloud.h"
#include "xview/types/labels.h"
#include "xview/types/localization.h"
#include "xview/types/option_field.h"

namespace xview {

struct RefineOptions {
  bool enabled = true;
  double cell_m = 0.8;  ///< side of the cells whose points make one distribution
  double reach_m =
      20;  ///< points of the last metres of the query take part: older ones have drifted
  int max_points = 4000;
  int iterations = 20;
  double first_gate_m = 2.0;    ///< a point may be this far from its distribution at first
  double last_gate_m = 0.8;     ///< and at the end
  double roughness_m = 0.1;     ///< standard deviation added to every distribution
  double tilt_sigma_deg = 0.5;  ///< trust in the common gravity direction of query and map
  double max_shift_m = 2.5;     ///< a refinement that moves further has found something else
};

template <class Visitor>
void visit(RefineOptions& o, Visitor&& field) {
  field("enabled", o.enabled, "refine accepted and ambiguous poses on the labelled clouds");
  field("cell_m", o.cell_m, Range{0.1, 10},
        "side of the cells whose points make one distribution [m]");
  field("reach_m", o.reach_m, Range{0, 1e4}, "use the points of the last metres of the query [m]");
  field("max_points", o.max_points, Range{10, 1e6}, "at most so many points of the query");
  field("iterations", o.iterations, Range{1, 1000}, "Gauss-Newton iterations");
  field("first_gate_m", o.first_gate_m, Range{0.01, 100},
        "largest distance to a distribution in the first iteration [m]");
  field("last_gate_m", o.last_gate_m, Range{0.01, 100}, "and in the last one [m]");
  field("roughness_m", o.roughness_m, Range{0.001, 10},
        "standard deviation added to every distribution [m]");
  field("tilt_sigma_deg", o.tilt_sigma_deg, Range{0.001, 360},
        "trust in the common gravity direction [deg]");
  field("max_shift_m", o.max_shift_m, Range{0, 1000},
        "give up if the pose moves further than this [m]");
}

/// The points of a map as normal distributions per cell and class (Magnusson 2009), of static
/// classes only.
class DistributionMap {
 public:
  DistributionMap(const LabelledCloud& map, const LabelSet& labels, double cell_m,
                  double roughness_m);
  ~DistributionMap();
  DistributionMap(DistributionMap&&) noexcept;
  std::size_t size() const;

 private:
  friend struct RefineAccess;
  struct Cells;
  std::unique_ptr<Cells> cells_;
};

struct Refinement {
  bool converged = false;  ///< other fields are valid only if true
  Eigen::Isometry3d T_map_query = Eigen::Isometry3d::Identity();
  double overlap =
      0;  ///< share of the points that have a distribution of their class within the last gate
  double residual_m = 0;  ///< roughness_m times the median Mahalanobis distance of those points
  /// Of the sensor pose: x y z [m], rx ry rz [rad], map frame, left increment. Points of one
  /// surface err together, and map and query see it from different sides: the inverse of the normal
  /// equations is scaled, and 5 cm and 0.05 degrees are added.
  Matrix6d covariance = Matrix6d::Zero();
  int iterations = 0;
};

/// Label-aware point-to-distribution registration: minimises sum w m with m = (p - mean)^T S^-1 (p
/// - mean) over the nearest distribution of the same class, w = 1 / (1 + m / 4)^2 (Geman-McClure),
/// by Gauss-Newton about the sensor position, with a gate that narrows. Dynamic and ignored classes
/// of `query` are left out.
Refinement refine(const DistributionMap& map, const LabelledCloud& query, const LabelSet& labels,
                  const Eigen::Isometry3d& T_map_query, const Eigen::Vector3d& sensor_in_query,
                  const RefineOptions& options);

}  // namespace xview
