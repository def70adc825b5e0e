// SPDX-License-Identifier: BSD-3-Clause
#include "pose/posterior.h"

#include <ceres/autodiff_cost_function.h>
#include <ceres/crs_matrix.h>
#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/product_manifold.h>
#include <ceres/solver.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>

#include "base/pose.h"
#include "residuals.h"

namespace xview::pose {
namespace {

constexpr double kUpright = 0.9961947;    ///< cos 5 degrees
constexpr double kMinInformation = 1e-9;  ///< 1/m^2 or 1/rad^2; less is no knowledge at all
constexpr double kSettledChange = 1e-8;   ///< relative change of the cost
constexpr int kMaxIterations = 50;        ///< right matches take 4 to 15
constexpr double kFullStepRadius = 1e8;   ///< damps what is open, and hardly anything else
constexpr double kShortestStep_m = 0.05;  ///< a robot that stands still is not known without error

using PoseManifold =
    ceres::ProductManifold<ceres::EuclideanManifold<3>, ceres::EigenQuaternionManifold>;

/// The poses that become unknowns; the last one of the window is always among them.
struct Window {
  std::vector<Eigen::Isometry3d> T_odom_sensor;
  std::vector<double> path_m;        ///< travelled up to each of them
  std::vector<std::size_t> carrier;  ///< per pose of the whole window: which of them carries it
};

Window thinWindow(const std::vector<Eigen::Isometry3d>& T_odom_sensor, std::size_t max_poses) {
  Window window;
  const std::size_t n = T_odom_sensor.size();
  const std::size_t stride = (n + max_poses - 1) / max_poses;
  const std::vector<double> path_m = pathLengths(T_odom_sensor);
  for (std::size_t i = 0; i < n; ++i) {
    window.carrier.push_back(window.T_odom_sensor.size());  // the next one that is kept
    if ((n - 1 - i) % stride != 0) continue;
    window.T_odom_sensor.push_back(T_odom_sensor[i]);
    window.path_m.push_back(path_m[i]);
  }
  return window;
}

/// What a match says, seen from the poses that are kept.
std::vector<MatchedVertex> seenByKept(std::vector<MatchedVertex> vertices, const Window& window) {
  const std::size_t last = window.carrier.size() - 1;
  for (MatchedVertex& vertex : vertices) {
    vertex.first_pose = window.carrier[std::min(vertex.first_pose, last)];
    vertex.last_pose = window.carrier[std::min(vertex.last_pose, last)];
  }
  return vertices;
}

/// The pose nearest to a vertex among those that saw it.
std::size_t nearestObserver(const std::vector<Eigen::Isometry3d>& T_odom_sensor,
                            const MatchedVertex& vertex) {
  std::size_t nearest = std::min(vertex.first_pose, vertex.last_pose);
  double nearest2 = (T_odom_sensor[nearest].translation() - vertex.p_odom).squaredNorm();
  for (std::size_t i = nearest + 1; i <= vertex.last_pose; ++i) {
    const double distance2 = (T_odom_sensor[i].translation() - vertex.p_odom).squaredNorm();
    if (distance2 >= nearest2) continue;
    nearest = i;
    nearest2 = distance2;
  }
  return nearest;
}

/// Poses and vertices as parameter blocks (residuals.h says how) with their constraints.
class Problem {
 public:
  Problem(const Window& window, const std::vector<MatchedVertex>& matched,
          const PosteriorOptions& options, double robust_scale,
          const Eigen::Isometry3d& T_map_query, bool gravity_known)
      : poses_(window.T_odom_sensor.size()), vertices_(matched.size()) {
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      set(poses_[i], T_map_query * window.T_odom_sensor[i]);
      problem_.AddParameterBlock(poses_[i].data(), 7, new PoseManifold());
    }
    for (std::size_t j = 0; j < vertices_.size(); ++j) {
      Eigen::Map<Eigen::Vector3d>(vertices_[j].data()) = T_map_query * matched[j].p_odom;
      problem_.AddParameterBlock(vertices_[j].data(), 3);
    }
    constrainOdometry(window, options);
    constrainVertices(window, matched, options.model, robust_scale);
    if (gravity_known) constrainGravity(window, options.model.gravity_sigma_rad);
  }

  Eigen::Isometry3d pose(std::size_t i) const {
    return poseOf(rotationOf(poses_[i].data()).normalized().toRotationMatrix(),
                  positionOf(poses_[i].data()));
  }

  ceres::Solver::Summary solve(ceres::Solver::Options solver) {
    solver.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (Position& vertex : vertices_)
      solver.linear_solver_ordering->AddElementToGroup(vertex.data(), 0);
    for (Pose& pose : poses_) solver.linear_solver_ordering->AddElementToGroup(pose.data(), 1);
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem_, &summary);
    return summary;
  }

  /// Of the last pose, all other unknowns marginalized; nothing if some direction is left open.
  std::optional<Matrix6d> lastPoseCovariance() {
    // In the order of the blocks: 6 columns per pose (x y z, then half the rotation vector, as
    // Ceres has it), then 3 per vertex.
    ceres::CRSMatrix crs;
    double cost = 0;
    if (!problem_.Evaluate({}, &cost, nullptr, nullptr, &crs) || !std::isfinite(cost))
      return std::nullopt;
    using RowMajor = Eigen::SparseMatrix<double, Eigen::RowMajor>;
    const RowMajor J = Eigen::Map<const RowMajor>(
        crs.num_rows, crs.num_cols, static_cast<Eigen::Index>(crs.values.size()), crs.rows.data(),
        crs.cols.data(), crs.values.data());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> information(
        Eigen::SparseMatrix<double>(J.transpose() * J));
    if (information.info() != Eigen::Success || information.vectorD().minCoeff() <= kMinInformation)
      return std::nullopt;
    const auto first = static_cast<Eigen::Index>(6 * (poses_.size() - 1));
    Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(J.cols(), 6);
    unit.middleRows<6>(first).setIdentity();
    Matrix6d covariance = Eigen::MatrixXd(information.solve(unit)).middleRows<6>(first);
    Eigen::Matrix<double, 6, 1> scale;
    scale << 1, 1, 1, 2, 2, 2;
    covariance = scale.asDiagonal() * covariance * scale.asDiagonal();
    return Matrix6d(0.5 * (covariance + covariance.transpose()));
  }

 private:
  using Pose = std::array<double, 7>;
  using Position = std::array<double, 3>;

  template <int kResiduals, int... kSizes, class Functor, class... Blocks>
  void constrain(const Functor& functor, ceres::LossFunction* loss, Blocks&... blocks) {
    problem_.AddResidualBlock(
        new ceres::AutoDiffCostFunction<Functor, kResiduals, kSizes...>(new Functor(functor)), loss,
        blocks.data()...);
  }

  static void set(Pose& pose, const Eigen::Isometry3d& T) {
    Eigen::Map<Eigen::Vector3d>(pose.data()) = T.translation();
    Eigen::Map<Eigen::Quaterniond>(pose.data() + 3) = Eigen::Quaterniond(T.linear()).normalized();
  }

  /// Errors of steps are independent, so variances add up along the way.
  void constrainOdometry(const Window& window, const PosteriorOptions& options) {
    for (std::size_t i = 1; i < poses_.size(); ++i) {
      const double root =
          std::sqrt(std::max(window.path_m[i] - window.path_m[i - 1], kShortestStep_m));
      const OdometryResidual step{window.T_odom_sensor[i - 1].inverse() * window.T_odom_sensor[i],
                                  options.odometry_sigma_m * root,
                                  options.odometry_sigma_rad * root};
      constrain<6, 7, 7>(step, nullptr, poses_[i - 1], poses_[i]);
    }
  }

  void constrainVertices(const Window& window, const std::vector<MatchedVertex>& matched,
                         const PosteriorOptions::Model& model, double robust_scale) {
    const double match_variance = model.match_sigma_m * model.match_sigma_m;
    for (std::size_t j = 0; j < matched.size(); ++j) {
      const MatchedVertex& vertex = matched[j];
      const std::size_t i = nearestObserver(window.T_odom_sensor, vertex);
      const ObservationResidual seen{window.T_odom_sensor[i].inverse() * vertex.p_odom,
                                     std::hypot(vertex.sigma_m, model.vertex_sigma_m)};
      constrain<3, 7, 3>(seen, nullptr, poses_[i], vertices_[j]);

      const Eigen::Matrix3d covariance =
          vertex.map_covariance + match_variance * Eigen::Matrix3d::Identity();
      const Eigen::Matrix3d L = covariance.llt().matrixL();
      constrain<3, 3>(MatchResidual{vertex.p_map, L.inverse()},
                      robust_scale > 0 ? new ceres::CauchyLoss(robust_scale) : nullptr,
                      vertices_[j]);
    }
  }

  /// Up is known once for the window, not anew at each pose.
  void constrainGravity(const Window& window, double sigma_rad) {
    const double sigma_each = sigma_rad * std::sqrt(static_cast<double>(poses_.size()));
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      const Eigen::Vector3d up =
          window.T_odom_sensor[i].linear().transpose() * Eigen::Vector3d::UnitZ();
      constrain<2, 7>(GravityResidual{up, sigma_each}, nullptr, poses_[i]);
    }
  }

  std::vector<Pose> poses_;
  std::vector<Position> vertices_;
  ceres::Problem problem_;  // refers to poses_ and vertices_
};

std::string inputProblem(const std::vector<Eigen::Isometry3d>& T_odom_sensor,
                         const std::vector<MatchedVertex>& vertices,
                         const Eigen::Isometry3d& T_map_query) {
  if (T_odom_sensor.empty()) return "no poses";
  if (vertices.empty()) return "no matched vertices";
  if (!T_map_query.matrix().allFinite()) return "the given pose is not finite";
  for (std::size_t i = 0; i < T_odom_sensor.size(); ++i) {
    if (!T_odom_sensor[i].matrix().allFinite()) {
      return "pose " + std::to_string(i) + " is not finite";
    }
  }
  for (std::size_t j = 0; j < vertices.size(); ++j) {
    const MatchedVertex& v = vertices[j];
    if (!v.p_odom.allFinite() || !v.p_map.allFinite() || !std::isfinite(v.sigma_m) ||
        !v.map_covariance.allFinite()) {
      return "matched vertex " + std::to_string(j) + " is not finite";
    }
    if (v.map_covariance.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff() < -1e-9) {
      return "matched vertex " + std::to_string(j) + " has a covariance with a negative axis";
    }
  }
  return "";
}

bool gravityKnown(const std::string& gravity, const Eigen::Isometry3d& T_map_query) {
  return gravity == "aligned" || (gravity == "auto" && T_map_query.linear()(2, 2) > kUpright);
}

/// The paper's start: the last pose at the mean of the matched map vertices, axes parallel.
Eigen::Isometry3d meanOfMatches(const std::vector<MatchedVertex>& vertices,
                                const Eigen::Isometry3d& T_odom_last) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const MatchedVertex& vertex : vertices) mean += vertex.p_map;
  mean /= static_cast<double>(vertices.size());
  return Eigen::Isometry3d(Eigen::Translation3d(mean - T_odom_last.translation()));
}

/// `full_steps`: those of Gauss-Newton, whatever they cost on the way.
void solve(Problem& problem, bool full_steps, Posterior& result) {
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_SCHUR;
  solver.max_num_iterations = kMaxIterations;
  solver.function_tolerance = kSettledChange;
  solver.parameter_tolerance = 1e-9;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  if (full_steps) {
    solver.initial_trust_region_radius = kFullStepRadius;
    solver.use_nonmonotonic_steps = true;
    solver.max_consecutive_nonmonotonic_steps = kMaxIterations;
  }
  const ceres::Solver::Summary summary = problem.solve(solver);
  result.cost_before = summary.initial_cost;
  result.cost_after = summary.final_cost;
  result.iterations = static_cast<int>(summary.iterations.size()) - 1;
  if (!summary.IsSolutionUsable()) result.problem = summary.message;
  if (full_steps && summary.termination_type == ceres::NO_CONVERGENCE)
    result.problem = "Gauss-Newton did not settle in " + std::to_string(result.iterations) +
                     " iterations, cost " + std::to_string(result.cost_after);
}

}  // namespace

Posterior maximizePosterior(const std::vector<Eigen::Isometry3d>& T_odom_sensor,
                            const std::vector<MatchedVertex>& vertices,
                            const Eigen::Isometry3d& T_map_query, const PosteriorOptions& options) {
  Posterior result;
  result.problem = inputProblem(T_odom_sensor, vertices, T_map_query);
  if (!result.problem.empty()) return result;

  const bool paper = options.solver == "gauss_newton";
  const Window window =
      thinWindow(T_odom_sensor, static_cast<std::size_t>(options.model.max_poses));
  Problem problem(window, seenByKept(vertices, window), options,
                  paper ? 0 : options.model.robust_scale,
                  paper ? meanOfMatches(vertices, T_odom_sensor.back()) : T_map_query,
                  gravityKnown(options.gravity, T_map_query));
  solve(problem, paper, result);
  if (!result.problem.empty()) return result;

  const auto covariance = problem.lastPoseCovariance();
  if (!covariance) {
    result.problem = std::to_string(vertices.size()) + " matches leave the pose open";
    return result;
  }
  result.covariance = *covariance;
  for (std::size_t i = 0; i < T_odom_sensor.size(); ++i) {
    const std::size_t k = window.carrier[i];
    result.T_map_sensor.push_back(problem.pose(k) * window.T_odom_sensor[k].inverse() *
                                  T_odom_sensor[i]);
  }
  result.converged = true;
  return result;
}

}  // namespace xview::pose
