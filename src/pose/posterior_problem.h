// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ceres/ordered_groups.h>
#include <ceres/problem.h>

#include <Eigen/SparseCore>
#include <array>
#include <memory>
#include <vector>

#include "xview/pose/posterior.h"

namespace xview {

/// Poses and vertices as parameter blocks (residuals.h says how) with their constraints.
class PosteriorProblem {
 public:
  using Pose = std::array<double, 7>;
  using VertexPosition = std::array<double, 3>;

  /// Residuals and Jacobian in the tangent space, robust loss applied. Columns: 6 per pose in order
  /// (x y z, then half the rotation increment, as Ceres has it), then 3 per vertex.
  struct Linearization {
    double cost = 0;
    Eigen::VectorXd residuals;
    Eigen::SparseMatrix<double, Eigen::RowMajor> jacobian;
    bool valid = false;
  };

  /// `path_m` is the distance travelled up to each pose.
  PosteriorProblem(const std::vector<Eigen::Isometry3d>& T_odom_sensor,
                   const std::vector<double>& path_m, const std::vector<MatchedVertex>& vertices,
                   const PosteriorOptions& options, bool gravity, double robust_scale);

  /// Places the whole window and its vertices rigidly.
  void start(const Eigen::Isometry3d& T_map_query);

  Eigen::Isometry3d pose(std::size_t i) const;
  std::size_t poses() const { return poses_.size(); }
  Linearization linearize();
  /// Adds an increment of the tangent space to all parameters.
  void add(const Eigen::VectorXd& increment);

  ceres::Problem& ceresProblem() { return *problem_; }
  /// Vertices before poses: the order of elimination.
  std::shared_ptr<ceres::ParameterBlockOrdering> eliminationOrder();

 private:
  void constrainOdometry(const std::vector<double>& path_m, const PosteriorOptions& options);
  void constrainVertices(const std::vector<MatchedVertex>& vertices,
                         const PosteriorOptions& options, double robust_scale);
  void constrainGravity(double sigma_rad);
  std::size_t nearestObserver(const MatchedVertex& vertex) const;

  std::vector<Eigen::Isometry3d> T_odom_sensor_;
  std::vector<Eigen::Vector3d> p_odom_;
  std::vector<Pose> poses_;
  std::vector<VertexPosition> vertices_;
  std::unique_ptr<ceres::Problem> problem_;  // refers to poses_ and vertices_
};

}  // namespace xview
