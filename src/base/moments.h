// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>

namespace xview {

/// Sums over points that give their mean and covariance.
struct Moments3 {
  double count = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();  ///< sum of p p^T

  void add(const Eigen::Vector3d& p, double weight = 1) {
    count += weight;
    sum += weight * p;
    squares += weight * p * p.transpose();
  }
  Eigen::Vector3d mean() const { return sum / count; }
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes() const {
    return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(squares / count -
                                                          mean() * mean().transpose());
  }
};

}  // namespace xview
