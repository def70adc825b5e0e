// SPDX-License-Identifier: BSD-3-Clause
#include "xview/pose/posterior.h"

#include <ceres/solver.h>

#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <optional>

#include "posterior_problem.h"

namespace xview {
namespace {

constexpr double kUpright = 0.9961947;    // cos 5 degrees
constexpr double kMinInformation = 1e-9;  // 1/m^2 or 1/rad^2; less is no knowledge at all
constexpr double kSettledChange = 1e-8;   // relative change of the cost

/// The poses that become unknowns, and where each pose of the window hangs on.
struct Window {
  std::vector<std::size_t> kept;     // positions in the window; the last pose is always kept
  std::vector<std::size_t> carrier;  // per pose of the window: position in `kept`
  std::vector<Eigen::Isometry3d> T_odom_sensor;  // of the kept ones
  std::vector<double> path_m;                    // of the kept ones
};

Window thinWindow(const std::vector<Eigen::Isometry3d>& T_odom_sensor, std::size_t max_poses) {
  Window window;
  const std::size_t n = T_odom_sensor.size();
  const std::size_t stride = (n + max_poses - 1) / max_poses;
  double path_m = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (i > 0) {
      path_m += (T_odom_sensor[i].translation() - T_odom_sensor[i - 1].translation()).norm();
    }
    if ((n - 1 - i) % stride == 0) {
      window.kept.push_back(i);
      window.T_odom_sensor.push_back(T_odom_sensor[i]);
      window.path_m.push_back(path_m);
    }
  }
  std::size_t k = 0;
  for (std::size_t i = 0; i < n; ++i) {
    while (k + 1 < window.kept.size() && window.kept[k] < i) ++k;
    window.carrier.push_back(k);
  }
  return window;
}

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

/// J^T J factorized; nothing if it leaves some direction open.
class NormalEquations {
 public:
  explicit NormalEquations(const PosteriorProblem::Linearization& at)
      : factor_(Eigen::SparseMatrix<double>(at.jacobian.transpose() * at.jacobian)) {}

  bool determined() const {
    return factor_.info() == Eigen::Success && factor_.vectorD().minCoeff() > kMinInformation;
  }
  Eigen::MatrixXd solve(const Eigen::MatrixXd& right) const { return factor_.solve(right); }

 private:
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor_;
};

std::string undetermined(std::size_t matches) {
  return std::to_string(matches) + " matches leave the pose open";
}

void solveTrustRegion(PosteriorProblem& problem, const PosteriorOptions& options,
                      Posterior& result) {
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_SCHUR;
  solver.linear_solver_ordering = problem.eliminationOrder();
  solver.max_num_iterations = options.max_iterations;
  solver.function_tolerance = kSettledChange;
  solver.parameter_tolerance = 1e-9;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem.ceresProblem(), &summary);
  result.cost_before = summary.initial_cost;
  result.cost_after = summary.final_cost;
  result.iterations = static_cast<int>(summary.iterations.size()) - 1;
  if (!summary.IsSolutionUsable()) result.problem = summary.message;
}

void solveGaussNewton(PosteriorProblem& problem, const PosteriorOptions& options,
                      std::size_t matches, Posterior& result) {
  auto at = problem.linearize();
  result.cost_before = at.cost;
  for (int i = 1; i <= options.max_iterations && at.valid; ++i) {
    const NormalEquations normal(at);
    if (!normal.determined()) {
      result.problem = undetermined(matches);
      return;
    }
    problem.add(-normal.solve(at.jacobian.transpose() * at.residuals));
    const double before = at.cost;
    at = problem.linearize();
    result.iterations = i;
    result.cost_after = at.cost;
    if (at.valid && std::abs(before - at.cost) <= kSettledChange * (at.cost + 1e-12)) return;
  }
  result.problem = "Gauss-Newton did not settle in " + std::to_string(result.iterations) +
                   " iterations, cost " + std::to_string(result.cost_after);
}

/// Of the last pose, all other unknowns marginalized.
std::optional<Matrix6d> lastPoseCovariance(PosteriorProblem& problem) {
  const auto at = problem.linearize();
  if (!at.valid) return std::nullopt;
  const NormalEquations normal(at);
  if (!normal.determined()) return std::nullopt;
  const auto first = static_cast<Eigen::Index>(6 * (problem.poses() - 1));
  Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(at.jacobian.cols(), 6);
  unit.middleRows<6>(first).setIdentity();
  Matrix6d covariance = normal.solve(unit).middleRows<6>(first);
  // Ceres' increment of a quaternion is half the rotation vector.
  Eigen::Matrix<double, 6, 1> scale;
  scale << 1, 1, 1, 2, 2, 2;
  covariance = scale.asDiagonal() * covariance * scale.asDiagonal();
  return Matrix6d(0.5 * (covariance + covariance.transpose()));
}

}  // namespace

Posterior maximizePosterior(const std::vector<Eigen::Isometry3d>& T_odom_sensor,
                            const std::vector<MatchedVertex>& vertices,
                            const Eigen::Isometry3d& T_map_query, const PosteriorOptions& options) {
  Posterior result;
  result.problem = inputProblem(T_odom_sensor, vertices, T_map_query);
  if (!result.problem.empty()) return result;

  const bool paper = options.solver == "gauss_newton";
  const Window window = thinWindow(T_odom_sensor, static_cast<std::size_t>(options.max_poses));
  std::vector<MatchedVertex> seen_by_kept = vertices;
  for (MatchedVertex& vertex : seen_by_kept) {
    vertex.first_pose = window.carrier[std::min(vertex.first_pose, T_odom_sensor.size() - 1)];
    vertex.last_pose = window.carrier[std::min(vertex.last_pose, T_odom_sensor.size() - 1)];
  }
  PosteriorProblem problem(window.T_odom_sensor, window.path_m, seen_by_kept, options,
                           gravityKnown(options.gravity, T_map_query),
                           paper ? 0 : options.robust_scale);
  problem.start(paper ? meanOfMatches(vertices, T_odom_sensor.back()) : T_map_query);
  if (paper) {
    solveGaussNewton(problem, options, vertices.size(), result);
  } else {
    solveTrustRegion(problem, options, result);
  }
  if (!result.problem.empty()) return result;

  const auto covariance = lastPoseCovariance(problem);
  if (!covariance) {
    result.problem = undetermined(vertices.size());
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

}  // namespace xview
