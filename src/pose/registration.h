// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "odometry_errors.h"
#include "pose/refine.h"

namespace xview::pose {

constexpr std::size_t kFewestPartners = 50;  ///< points with a distribution, for a pose

/// A point of a query that takes part in a registration.
struct QueryPoint {
  Eigen::Vector3d p;  ///< query frame
  std::uint32_t group = kNoGroup;
  Eigen::Vector3d view = Eigen::Vector3d::Zero();  ///< unit vector to who saw it; zero if unknown
  std::size_t pose = 0;                            ///< that it was seen from
};

/// Points of static classes, about `max_points` at most, in the order of the cloud: fewer of ground
/// and more of posts than the share that they have of it.
std::vector<QueryPoint> choosePoints(const RefineQuery& query, const LabelSet& labels,
                                     int max_points);

/// Where a point lies, and what it is of: points of one block err together.
using Block = std::array<std::int64_t, 3>;
Block blockOf(const QueryPoint& q);

/// A pose, and how far the odometry is off at the knots of the drift.
struct Estimate {
  Eigen::Isometry3d T_map_query;
  Eigen::VectorXd drift;
};

/// One Gauss-Newton system about the last sensor: unknown are (translation, rotation vector), left
/// increment in the map frame, and the same for each knot of the drift.
struct NormalEquations {
  Eigen::MatrixXd H;
  Eigen::VectorXd b;
  double cost = 0;  ///< of points and priors
};

/// Of each point, at the last pose that was asked for.
using LastPartners = std::vector<DistributionMap::Nearest>;

/// How far off a point may be to take part.
struct Scope {
  double gate_m;
  double tolerance;  ///< of a squared Mahalanobis distance; 1 at the end
};

/// A point beside the distribution that it belongs to.
struct Partner {
  Eigen::Matrix<double, 3, 6> J;   ///< of the point, about the last sensor
  Eigen::Matrix<double, 6, 3> JW;  ///< J^T times weighted information
  Eigen::Vector3d r;               ///< distribution - point, map frame
  double mahalanobis;              ///< squared
  Eigen::Vector3d view, map_view;  ///< to who saw the point and the distribution; zero if unknown
};

/// What the points say, by pose: those of one pose are one rigid body.
struct Evidence {
  explicit Evidence(std::size_t pose_count) : poses(pose_count) {}
  void add(const QueryPoint& point, const Partner& partner);

  struct System {
    Matrix6d H = Matrix6d::Zero();
    Vector6d b = Vector6d::Zero();
  };
  std::vector<System> poses;
  std::size_t partners = 0;  ///< points with a distribution
  double cost = 0;           ///< sum over points; without a partner 0, exactly there -4
};

/// How much of the drift of the options a window is expected to have, and how far off its points
/// may be at first (see Scope).
struct DriftPrior {
  double scale;
  double first_tolerance;
};

/// Fits a window to the distributions of a map, under one prior of its drift.
class Registration {
 public:
  /// All must outlive the registration.
  Registration(const DistributionMap& map, const RefineQuery& query,
               const Eigen::Isometry3d& T_map_query, const std::vector<QueryPoint>& points,
               const RefineOptions& options, const DriftPrior& prior);

  struct Descent {
    bool valid = false;
    Estimate at;
    std::size_t partners = 0;
  };
  /// `weigh`: finds out on the way what a point is worth.
  Descent descend(const std::vector<QueryPoint>& points, const Estimate& start, int iterations,
                  bool weigh);

  struct Start {
    Estimate at;
    double rise_m = 0;                               ///< of the given pose before all else
    Eigen::Matrix3d open = Eigen::Matrix3d::Zero();  ///< covariance of where one may start as well
  };
  Estimate start() const { return {given_, Eigen::VectorXd::Zero(drift_.size())}; }
  /// The ground of a place may have been a table of it, so the given pose rises or sinks to where
  /// few points fit best. Along a street little tells how far: few points go from places to both
  /// sides, and the start is the mean of where they get to, by likelihood. Where they agree that is
  /// the best one; where the street shows nothing it is the middle, and `open` is wide.
  Start multiStart(const std::vector<QueryPoint>& points);

  const DriftChain& drift() const { return drift_; }
  double pointWeight() const { return point_weight_; }
  std::size_t poseCount() const { return poses_.size(); }
  Scope lastScope() const { return {options_.model.last_gate_m, 1}; }
  /// Of the last pose and, against it, of any other pose of the query.
  Eigen::Vector3d sensorOf(const Estimate& at) const { return at.T_map_query * sensor_in_query_; }
  Eigen::Vector3d sensorAt(const Estimate& at, std::size_t pose) const {
    return poseAt(at, pose) * poses_[pose].translation();
  }

  /// T_map_query as it is right for a pose of the query.
  Eigen::Isometry3d poseAt(const Estimate& at, std::size_t pose) const;

  Evidence evidenceAt(const Estimate& at, const std::vector<QueryPoint>& points, const Scope& scope,
                      LastPartners* last = nullptr) const;
  NormalEquations assemble(const Evidence& evidence, const Estimate& at) const;
  /// Calls visit(point, partner) for the points that have one. `last`: of the same points, if poses
  /// follow that are hardly apart.
  template <class Visit>
  void forPartners(const std::vector<QueryPoint>& points, const Estimate& at, const Scope& scope,
                   Visit&& visit, LastPartners* last = nullptr) const {
    if (last) last->resize(points.size());
    const Eigen::Vector3d about = sensorOf(at);
    std::size_t pose = poses_.size();
    Eigen::Isometry3d T = at.T_map_query;
    Partner partner;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const QueryPoint& q = points[i];
      if (q.pose != pose) T = poseAt(at, pose = q.pose);
      DistributionMap::Nearest none;
      if (findPartner(q, T, about, scope, last ? (*last)[i] : none, partner)) visit(q, partner);
    }
  }

 private:
  DriftChain driftOf(const std::vector<QueryPoint>& points, double scale) const;
  bool findPartner(const QueryPoint& q, const Eigen::Isometry3d& T, const Eigen::Vector3d& about,
                   const Scope& scope, DistributionMap::Nearest& last, Partner& partner) const;
  void addPriors(const Estimate& at, NormalEquations& n) const;
  double riseToFit(const std::vector<QueryPoint>& points) const;
  double bestRise(const std::vector<QueryPoint>& points, double weight) const;
  Estimate risen(double rise_m) const;  ///< the given pose
  double measuredWeight(const std::vector<QueryPoint>& points, const Estimate& at) const;
  Estimate moved(const Estimate& at, const Eigen::VectorXd& step) const;

  const DistributionMap& map_;
  const std::vector<Eigen::Isometry3d>& poses_;
  const Eigen::Vector3d sensor_in_query_, up_in_query_;
  const Eigen::Isometry3d given_;
  const RefineOptions& options_;
  const double first_tolerance_;
  const DriftChain drift_;
  double point_weight_;  ///< information of a point over that of an independent one
};

}  // namespace xview::pose
