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
  double cell_m = 0.8;       ///< side of the cells whose points make one distribution
  double reach_m = 40;       ///< points of the last metres of the query take part
  double max_sigma_m = 0.5;  ///< points of map and query that are known less well take no part
  int max_points = 3000;
  int iterations = 20;
  double first_gate_m = 2.0;    ///< a point may be this far from its distribution at first
  double last_gate_m = 0.8;     ///< and at the end
  double roughness_m = 0.05;    ///< standard deviation added to every distribution
  double tilt_sigma_deg = 0.5;  ///< trust in the common gravity direction of query and map
  double drift_share = 0.03;    ///< error of the odometry per way where a window shows drift
  double drift_deg_per_m = 0.045;
  double start_reach_m = 1;  ///< starts this far to both sides along the least certain direction
  double start_sigma_m = 1;  ///< trust in the given pose, in the plane
  double start_sigma_deg = 1.5;  ///< and about the vertical
  double max_shift_m = 2.5;      ///< a refinement that moves further has found something else
};

template <class Visitor>
void visit(RefineOptions& o, Visitor&& field) {
  field("enabled", o.enabled, "refine accepted and ambiguous poses on the labelled clouds");
  field("cell_m", o.cell_m, Range{0.1, 10},
        "side of the cells whose points make one distribution [m]");
  field("reach_m", o.reach_m, Range{0, 1e4}, "use the points of the last metres of the query [m]");
  field("max_sigma_m", o.max_sigma_m, Range{0.01, 100},
        "leave out camera points whose depth is known less well [m]");
  field("max_points", o.max_points, Range{10, 1e6}, "at most so many points of the query");
  field("iterations", o.iterations, Range{1, 1000}, "Gauss-Newton iterations");
  field("first_gate_m", o.first_gate_m, Range{0.01, 100},
        "largest distance to a distribution in the first iteration [m]");
  field("last_gate_m", o.last_gate_m, Range{0.01, 100}, "and in the last one [m]");
  field("roughness_m", o.roughness_m, Range{0.001, 10},
        "standard deviation added to every distribution [m]");
  field("tilt_sigma_deg", o.tilt_sigma_deg, Range{0.001, 360},
        "trust in the common gravity direction [deg]");
  field("drift_share", o.drift_share, Range{0, 1},
        "error of the odometry per way, where a window shows drift; 0 = none");
  field("drift_deg_per_m", o.drift_deg_per_m, Range{0, 10},
        "same for the direction [deg per metre]");
  field("start_reach_m", o.start_reach_m, Range{0, 10},
        "also start this far to both sides, along the least certain direction; 0 = do not [m]");
  field("start_sigma_m", o.start_sigma_m, Range{0, 1e3},
        "trust in the given pose, in the plane; 0 = none, in its heading neither [m]");
  field("start_sigma_deg", o.start_sigma_deg, Range{0.001, 360},
        "trust in the heading of the given pose [deg]");
  field("max_shift_m", o.max_shift_m, Range{0, 1000},
        "give up if the pose moves further than this [m]");
}

class DistributionCells;

/// The points of a map as normal distributions per cell and class (Magnusson 2009), of static
/// classes only. Along a surface that runs through its cell the mean of the cell is no landmark:
/// what an evenly filled cell would say is taken off.
class DistributionMap {
 public:
  /// `viewpoints`: T_map_sensor that the map was seen from; they tell which side of a thing it
  /// knows. May be empty. The cloud must outlive this: the distributions are made where they are
  /// needed. That changes no result, and threads may share a map.
  DistributionMap(const LabelledCloud& map, const LabelSet& labels,
                  const std::vector<Eigen::Isometry3d>& viewpoints, const RefineOptions& options);
  /// The same with a cloud of its own.
  DistributionMap(LabelledCloud&& map, const LabelSet& labels,
                  const std::vector<Eigen::Isometry3d>& viewpoints, const RefineOptions& options);
  ~DistributionMap();
  DistributionMap(DistributionMap&&) noexcept;
  std::size_t size() const;  ///< makes all of them

 private:
  friend class DistributionCells;
  std::unique_ptr<const LabelledCloud> kept_;  ///< null: somebody else's
  std::unique_ptr<const DistributionCells> cells_;
};

/// The labelled points of a query and where they were seen from.
struct RefineQuery {
  const LabelledCloud& cloud;  ///< Point::view is a position in `poses`; the typical sigma of the
                               ///< points goes into the covariance
  const std::vector<Eigen::Isometry3d>&
      poses;  ///< T_query_sensor, at least one; the last is refined
};

/// What the covariance is made of: how far each kind of error reaches the pose through the fit. Set
/// by maximum likelihood on accepted windows of simulated towns with clean and with noisy depth,
/// with and without added drift, and of scanners.
struct RefinementErrors {
  /// Points of a block err together: of the spread of blocks.
  static constexpr double kPoints = 0.65;
  /// Between the sides of things that query and map saw, for all things of a kind.
  static constexpr double kSide_m = 0.037;
  /// Of the drift and its turn that were presumed, and times as much where a window shows drift.
  static constexpr double kDrift = 0.4, kDriftTurn = 0.2, kShownDrift = 4;
  /// All these double in variance where depth is known no better than this,
  static constexpr double kKnownWell_m = 0.1;
  /// and where points fit so badly that an independent one is worth this much of itself; below that
  /// quickly more. Those of bent scans do.
  static constexpr double kBent = 0.033;
  /// Of the depth error that all points have in common, in the plane.
  static constexpr double kCommon = 0.03;
  /// The given pose errs by so much more than its trust says.
  static constexpr double kGiven = 2;
  /// What points leave open that are worth so much more is open.
  static constexpr double kWorth = 3000;
  /// Of how far starts to both sides end apart, along a street that shows nothing lengthwise.
  static constexpr double kStarts = 0.7;
  static constexpr double kFloor_m = 0.0005, kFloor_rad = 0.00008;
  /// Of single looks in themselves, as by motion while a scanner turns.
  static constexpr double kLook_m = 0.001, kLook_rad = 0.00012;
};

struct Refinement {
  bool converged = false;  ///< other fields are valid only if true
  Eigen::Isometry3d T_map_query = Eigen::Isometry3d::Identity();  ///< right for the last pose
  double overlap =
      0;  ///< share of the points that have a distribution of their class within the last gate
  double scale =
      1;  ///< how long the last ways are in the map, over how long the odometry says they are
  /// Of the last pose: x y z [m], rx ry rz [rad], map frame, left increment: errors of points, of
  /// drift and of single poses; see RefinementErrors. An error of the map as a whole against the
  /// world is not in it.
  Matrix6d covariance = Matrix6d::Zero();
  int iterations = 0;
};

/// Label-aware point-to-distribution registration: minimises sum w m with m = (p - mean)^T W (p -
/// mean) over the nearest distribution of the same class, w = 1 / (1 + m / 4)^2 (Geman-McClure), by
/// Gauss-Newton about the last sensor position with a gate that narrows. Unknown are that pose and
/// the errors of the odometry at knots along the way to it; the given pose counts as one
/// observation. It is done twice: with little drift, and with that of the options from points that
/// may be far off at first. The second counts only if the points fit clearly better.
/// Where the other side of a thing was mapped, a point counts a tenth. Dynamic and ignored classes
/// are left out.
Refinement refine(const DistributionMap& map, const RefineQuery& query, const LabelSet& labels,
                  const Eigen::Isometry3d& T_map_query, const RefineOptions& options);

}  // namespace xview
