// SPDX-License-Identifier: BSD-3-Clause
#include "posterior_problem.h"

#include <ceres/autodiff_cost_function.h>
#include <ceres/crs_matrix.h>
#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/product_manifold.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "xview/pose/residuals.h"

namespace xview {
namespace {

constexpr double kShortestStep_m = 0.05;  // a robot that stands still is not known without error

using PoseManifold =
    ceres::ProductManifold<ceres::EuclideanManifold<3>, ceres::EigenQuaternionManifold>;

template <int kResiduals, int... kSizes, class Functor>
ceres::CostFunction* cost(const Functor& functor) {
  return new ceres::AutoDiffCostFunction<Functor, kResiduals, kSizes...>(new Functor(functor));
}

}  // namespace

PosteriorProblem::PosteriorProblem(const std::vector<Eigen::Isometry3d>& T_odom_sensor,
                                   const std::vector<double>& path_m,
                                   const std::vector<MatchedVertex>& vertices,
                                   const PosteriorOptions& options, bool gravity,
                                   double robust_scale)
    : T_odom_sensor_(T_odom_sensor),
      poses_(T_odom_sensor.size()),
      vertices_(vertices.size()),
      problem_(std::make_unique<ceres::Problem>()) {
  for (const MatchedVertex& vertex : vertices) p_odom_.push_back(vertex.p_odom);
  start(Eigen::Isometry3d::Identity());
  for (Pose& pose : poses_) problem_->AddParameterBlock(pose.data(), 7, new PoseManifold());
  for (VertexPosition& vertex : vertices_) problem_->AddParameterBlock(vertex.data(), 3);
  constrainOdometry(path_m, options);
  constrainVertices(vertices, options, robust_scale);
  if (gravity) constrainGravity(options.gravity_sigma_rad);
}

void PosteriorProblem::start(const Eigen::Isometry3d& T_map_query) {
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    const Eigen::Isometry3d T = T_map_query * T_odom_sensor_[i];
    Eigen::Map<Eigen::Vector3d>(poses_[i].data()) = T.translation();
    Eigen::Map<Eigen::Quaterniond>(poses_[i].data() + 3) =
        Eigen::Quaterniond(T.linear()).normalized();
  }
  for (std::size_t j = 0; j < vertices_.size(); ++j) {
    Eigen::Map<Eigen::Vector3d>(vertices_[j].data()) = T_map_query * p_odom_[j];
  }
}

Eigen::Isometry3d PosteriorProblem::pose(std::size_t i) const {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = positionOf(poses_[i].data());
  T.linear() = rotationOf(poses_[i].data()).normalized().toRotationMatrix();
  return T;
}

void PosteriorProblem::constrainOdometry(const std::vector<double>& path_m,
                                         const PosteriorOptions& options) {
  for (std::size_t i = 1; i < poses_.size(); ++i) {
    // Errors of steps are independent, so variances add up along the way.
    const double root = std::sqrt(std::max(path_m[i] - path_m[i - 1], kShortestStep_m));
    const OdometryResidual residual{T_odom_sensor_[i - 1].inverse() * T_odom_sensor_[i],
                                    options.odometry_sigma_m * root,
                                    options.odometry_sigma_rad * root};
    problem_->AddResidualBlock(cost<6, 7, 7>(residual), nullptr, poses_[i - 1].data(),
                               poses_[i].data());
  }
}

void PosteriorProblem::constrainVertices(const std::vector<MatchedVertex>& vertices,
                                         const PosteriorOptions& options, double robust_scale) {
  const double match_variance = options.match_sigma_m * options.match_sigma_m;
  for (std::size_t j = 0; j < vertices.size(); ++j) {
    const MatchedVertex& vertex = vertices[j];
    const std::size_t i = nearestObserver(vertex);
    const ObservationResidual seen{T_odom_sensor_[i].inverse() * vertex.p_odom,
                                   std::hypot(vertex.sigma_m, options.vertex_sigma_m)};
    problem_->AddResidualBlock(cost<3, 7, 3>(seen), nullptr, poses_[i].data(), vertices_[j].data());

    const Eigen::Matrix3d covariance =
        vertex.map_covariance + match_variance * Eigen::Matrix3d::Identity();
    const Eigen::Matrix3d L = covariance.llt().matrixL();
    const MatchResidual match{vertex.p_map, L.inverse()};
    ceres::LossFunction* loss = robust_scale > 0 ? new ceres::CauchyLoss(robust_scale) : nullptr;
    problem_->AddResidualBlock(cost<3, 3>(match), loss, vertices_[j].data());
  }
}

void PosteriorProblem::constrainGravity(double sigma_rad) {
  // Up is known once for the window, not anew at each pose.
  const double sigma_each = sigma_rad * std::sqrt(static_cast<double>(poses_.size()));
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    const Eigen::Vector3d up = T_odom_sensor_[i].linear().transpose() * Eigen::Vector3d::UnitZ();
    problem_->AddResidualBlock(cost<2, 7>(GravityResidual{up, sigma_each}), nullptr,
                               poses_[i].data());
  }
}

std::size_t PosteriorProblem::nearestObserver(const MatchedVertex& vertex) const {
  const std::size_t last = std::min(vertex.last_pose, poses_.size() - 1);
  std::size_t nearest = std::min(vertex.first_pose, last);
  double nearest2 = (T_odom_sensor_[nearest].translation() - vertex.p_odom).squaredNorm();
  for (std::size_t i = nearest + 1; i <= last; ++i) {
    const double distance2 = (T_odom_sensor_[i].translation() - vertex.p_odom).squaredNorm();
    if (distance2 < nearest2) {
      nearest = i;
      nearest2 = distance2;
    }
  }
  return nearest;
}

PosteriorProblem::Linearization PosteriorProblem::linearize() {
  ceres::Problem::EvaluateOptions options;
  for (Pose& pose : poses_) options.parameter_blocks.push_back(pose.data());
  for (VertexPosition& vertex : vertices_) options.parameter_blocks.push_back(vertex.data());
  Linearization result;
  std::vector<double> residuals;
  ceres::CRSMatrix jacobian;
  result.valid = problem_->Evaluate(options, &result.cost, &residuals, nullptr, &jacobian) &&
                 std::isfinite(result.cost);
  if (!result.valid) return result;
  result.residuals =
      Eigen::Map<Eigen::VectorXd>(residuals.data(), static_cast<Eigen::Index>(residuals.size()));
  result.jacobian = Eigen::Map<Eigen::SparseMatrix<double, Eigen::RowMajor>>(
      jacobian.num_rows, jacobian.num_cols, static_cast<Eigen::Index>(jacobian.values.size()),
      jacobian.rows.data(), jacobian.cols.data(), jacobian.values.data());
  return result;
}

void PosteriorProblem::add(const Eigen::VectorXd& increment) {
  const PoseManifold manifold;
  const double* delta = increment.data();
  for (Pose& pose : poses_) {
    Pose moved;
    manifold.Plus(pose.data(), delta, moved.data());
    pose = moved;
    delta += 6;
  }
  for (VertexPosition& vertex : vertices_) {
    for (double& coordinate : vertex) coordinate += *delta++;
  }
}

std::shared_ptr<ceres::ParameterBlockOrdering> PosteriorProblem::eliminationOrder() {
  auto order = std::make_shared<ceres::ParameterBlockOrdering>();
  for (VertexPosition& vertex : vertices_) order->AddElementToGroup(vertex.data(), 0);
  for (Pose& pose : poses_) order->AddElementToGroup(pose.data(), 1);
  return order;
}

}  // namespace xview
