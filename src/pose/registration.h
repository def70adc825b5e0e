// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "distribution_cells.h"
#include "drift_chain.h"
#include "query_points.h"
#include "xview/pose/refine.h"

namespace xview {

constexpr std::size_t kFewestPartners = 50;  ///< points with a distribution, for a pose

/// A pose, and how far the odometry is off at the knots of the chain.
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

/// What the points of one pose say, one rigid body.
struct PoseSystem {
  Matrix6d H = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();
};

/// How far off a point may be to have a say.
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

/// What the points say.
struct Evidence {
  std::vector<PoseSystem> poses;
  std::size_t partners = 0;  ///< points with a distribution
  double cost = 0;           ///< sum over points; without a partner 0, exactly there -4
  void add(const QueryPoint& point, const Partner& partner);
};

/// How much of the drift of the options a window is presumed to have, and how far off its points
/// may be at first (see Scope).
struct Presumption {
  double drift;
  double first_tolerance;
};

/// Fits a window to the distributions of a map, under one presumption about its drift.
class Registration {
 public:
  Registration(const DistributionMap& map, const RefineQuery& query,
               const Eigen::Isometry3d& T_map_query, const std::vector<QueryPoint>& points,
               const RefineOptions& options, const Presumption& presumption);

  struct Descent {
    bool valid = false;
    Estimate at;
    Evidence last;
    int iterations = 0;
  };
  /// `measure`: finds out on the way what a point is worth.
  Descent descend(const std::vector<QueryPoint>& points, const Estimate& start, int iterations,
                  bool measure);
  struct Start {
    Estimate at;
    Eigen::Matrix3d open = Eigen::Matrix3d::Zero();  ///< covariance of where one may start as well
  };
  /// Along a street little tells how far: few points go from places to both sides, and the start is
  /// the mean of where they get to, by likelihood. Where they agree that is the best one; where the
  /// street shows nothing it is the middle, and `open` is wide.
  Start likelyStart(const std::vector<QueryPoint>& points);

  Estimate start() const { return {given_, Eigen::VectorXd::Zero(chain_.size())}; }
  bool canDrift() const { return chain_.knots() > 0; }
  const DriftChain& chain() const { return chain_; }
  /// Information of a point over that of an independent one.
  double trust() const { return trust_; }
  std::size_t poseCount() const { return poses_.size(); }
  /// Of pose and, against it, of any other pose of the query.
  Eigen::Vector3d sensorOf(const Estimate& at) const { return at.T_map_query * sensor_in_query_; }
  Eigen::Vector3d sensorAt(const Estimate& at, std::size_t pose) const {
    return poseAt(at, pose) * poses_[pose].translation();
  }
  /// Length of the way in the map over that of the odometry.
  double scaleOf(const Estimate& at) const;
  double costOf(const std::vector<QueryPoint>& points, const Estimate& at) const {
    return look(points, at, lastScope()).cost;
  }

  Scope lastScope() const { return {options_.last_gate_m, 1}; }
  Evidence look(const std::vector<QueryPoint>& points, const Estimate& at,
                const Scope& scope) const;
  NormalEquations assemble(const Evidence& evidence, const Estimate& at) const;
  /// Calls visit(point, partner) for the points that have one.
  template <class Visit>
  void forPartners(const std::vector<QueryPoint>& points, const Estimate& at, const Scope& scope,
                   Visit&& visit) const {
    const Eigen::Vector3d about = sensorOf(at);
    std::size_t pose = poses_.size();
    Eigen::Isometry3d T = at.T_map_query;
    Partner partner;
    for (const QueryPoint& q : points) {
      if (q.pose != pose) T = poseAt(at, pose = q.pose);
      if (findPartner(q, T, about, scope, partner)) visit(q, partner);
    }
  }

 private:
  DriftChain chainOf(const std::vector<QueryPoint>& points) const;
  Eigen::Isometry3d poseAt(const Estimate& at, std::size_t pose) const;
  bool findPartner(const QueryPoint& q, const Eigen::Isometry3d& T, const Eigen::Vector3d& about,
                   const Scope& scope, Partner& partner) const;
  void addPriors(const Estimate& at, NormalEquations& n) const;
  void addGivenPose(const Estimate& at, NormalEquations& n) const;
  double measuredTrust(const std::vector<QueryPoint>& points, const Estimate& at) const;
  Vector6d givenInformation() const;
  double gravityInformation() const;
  Estimate moved(const Estimate& at, const Eigen::VectorXd& step) const;

  const DistributionCells& cells_;
  const std::vector<Eigen::Isometry3d>& poses_;
  const Eigen::Vector3d sensor_in_query_, up_in_query_;
  const Eigen::Isometry3d given_;
  const RefineOptions& options_;
  const Presumption presumption_;
  DriftChain chain_;
  double trust_;  ///< information of a point over that of an independent one
};

}  // namespace xview
