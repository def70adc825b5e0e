// SPDX-License-Identifier: BSD-3-Clause
#include "distribution_cells.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "base/median.h"

namespace xview::pose {

Eigen::Matrix3f surplusInformation(const Eigen::Matrix3f& covariance, float side, float variance,
                                   float within) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> axes(0.5f *
                                                            (covariance + covariance.transpose()));
  const float even = 1 / (side * side / 12 + variance);
  const Eigen::Array3f spread = axes.eigenvalues().array().max(0.f) + variance;
  Eigen::Vector3f information = (spread.inverse() - even).max(0.f);
  information.tail<2>() *= within;
  return axes.eigenvectors() * information.asDiagonal() * axes.eigenvectors().transpose();
}

bool tellsShape(const Cell& cell) {
  constexpr std::uint32_t kEnough = 8;
  constexpr float kWidthOfLine = 0.3f, kLevel = 0.5f;
  if (cell.points < kEnough) return false;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> axes;
  axes.computeDirect(cell.covariance());
  const Eigen::Array3f spread = axes.eigenvalues().array().max(0.f).sqrt();
  return spread(1) > kWidthOfLine * spread(2) || std::abs(axes.eigenvectors()(2, 2)) > kLevel;
}

Eigen::Vector3f laidOn(const Cell& around, const Eigen::Vector3f& mean) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> axes(around.covariance());
  const Eigen::Array3f spread = axes.eigenvalues().array().max(0.f);
  const Eigen::Array3f own = spread / std::max(1e-9f, spread(2));
  const Eigen::Array3f away = axes.eigenvectors().transpose() * (mean - around.distribution.mean);
  return around.distribution.mean + axes.eigenvectors() * (own * away).matrix();
}

float medianThickness(const std::vector<Cell>& cells) {
  constexpr std::uint32_t kFewest = 8;
  std::vector<float> variances;
  for (const Cell& cell : cells) {
    if (cell.points < kFewest) continue;
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver;
    solver.computeDirect(cell.covariance(), Eigen::EigenvaluesOnly);
    variances.push_back(std::max(0.0F, solver.eigenvalues()[0]));
  }
  if (variances.empty()) return 0;
  return std::sqrt(medianOf(std::move(variances)));
}

}  // namespace xview::pose
