// SPDX-License-Identifier: BSD-3-Clause
#include "pose/align.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <cmath>

namespace xview::pose {
namespace {

constexpr double kMinSpreadRatio = 1e-3;  // across / along, below which points are one line
constexpr double kMinSpread_m = 1e-9;

using Points = std::vector<Eigen::Vector3d>;

struct Moments {
  std::string problem;
  Eigen::Vector3d source_mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d target_mean = Eigen::Vector3d::Zero();
  // Centred second moments per point.
  Eigen::Matrix3d source = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d target = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();  // target * source^T
};

std::string inputProblem(const Points& source, const Points& target, std::size_t needed) {
  if (source.size() != target.size()) {
    return std::to_string(source.size()) + " source points for " + std::to_string(target.size()) +
           " target points";
  }
  for (std::size_t i = 0; i < source.size(); ++i) {
    if (!source[i].allFinite() || !target[i].allFinite())
      return "point " + std::to_string(i) + " is not finite";
  }
  if (source.size() >= needed) return "";
  return std::to_string(source.size()) + " points, at least " + std::to_string(needed) +
         " are needed";
}

Moments momentsOf(const Points& source, const Points& target, std::size_t needed) {
  Moments m;
  m.problem = inputProblem(source, target, needed);
  if (!m.problem.empty()) return m;
  const auto count = static_cast<double>(source.size());
  for (std::size_t i = 0; i < source.size(); ++i) {
    m.source_mean += source[i];
    m.target_mean += target[i];
  }
  m.source_mean /= count;
  m.target_mean /= count;
  for (std::size_t i = 0; i < source.size(); ++i) {
    const Eigen::Vector3d s = source[i] - m.source_mean, t = target[i] - m.target_mean;
    m.source += 1 / count * s * s.transpose();
    m.target += 1 / count * t * t.transpose();
    m.cross += 1 / count * t * s.transpose();
  }
  return m;
}

/// "" if points with these second moments span at least a plane.
std::string lineProblem(const Eigen::Matrix3d& moments, const char* side) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(moments, Eigen::EigenvaluesOnly);
  const Eigen::Vector3d spread = solver.eigenvalues().cwiseMax(0).cwiseSqrt();  // rising
  if (spread[2] < kMinSpread_m) return std::string(side) + " points coincide";
  if (spread[1] < kMinSpreadRatio * spread[2]) {
    return std::string(side) + " points are collinear";
  }
  return "";
}

Alignment failure(const std::string& problem) {
  Alignment result;
  result.problem = problem;
  return result;
}

Alignment success(const Eigen::Matrix3d& R, const Moments& m, const Points& source,
                  const Points& target) {
  Alignment result;
  result.valid = true;
  result.T_target_source.linear() = R;
  result.T_target_source.translation() = m.target_mean - R * m.source_mean;
  double sum = 0;
  for (std::size_t i = 0; i < source.size(); ++i)
    sum += ((target[i] - m.target_mean) - R * (source[i] - m.source_mean)).squaredNorm();
  result.rms_m = std::sqrt(sum / static_cast<double>(source.size()));
  return result;
}

}  // namespace

Alignment alignPoints(const Points& source, const Points& target) {
  const Moments m = momentsOf(source, target, 3);
  if (!m.problem.empty()) return failure(m.problem);
  for (const auto& problem : {lineProblem(m.source, "source"), lineProblem(m.target, "target")}) {
    if (!problem.empty()) return failure(problem);
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m.cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d s = svd.singularValues();
  // Umeyama (1991), equations (39), (40) and the lemma: the last axis is turned if det < 0.
  const bool mirrored = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0;
  const double gap = mirrored ? s[1] - s[2] : s[1];
  if (gap <= kMinSpreadRatio * kMinSpreadRatio * s[0]) {
    return failure("the rotation is not determined by these points");
  }
  const Eigen::Vector3d signs(1, 1, mirrored ? -1 : 1);
  return success(svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose(), m, source, target);
}

Alignment alignPointsInYaw(const Points& source, const Points& target) {
  const Moments m = momentsOf(source, target, 2);
  if (!m.problem.empty()) return failure(m.problem);
  // Maximises sum t . Rz(yaw) s over yaw.
  const double sine = m.cross(1, 0) - m.cross(0, 1);
  const double cosine = m.cross(0, 0) + m.cross(1, 1);
  const double spread = std::sqrt(m.source.topLeftCorner<2, 2>().trace()) *
                        std::sqrt(m.target.topLeftCorner<2, 2>().trace());
  if (spread < kMinSpread_m * kMinSpread_m) return failure("points coincide in the plane");
  if (std::hypot(sine, cosine) < kMinSpreadRatio * kMinSpreadRatio * spread) {
    return failure("the yaw is not determined by these points");
  }
  const double yaw_rad = std::atan2(sine, cosine);
  return success(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix(), m, source,
                 target);
}

}  // namespace xview::pose
