// SPDX-License-Identifier: BSD-3-Clause
#include "base/pose.h"

#include <Eigen/SVD>
#include <cmath>

namespace xview {

double yawOf(const Eigen::Matrix3d& R) { return std::atan2(R(1, 0), R(0, 0)); }

Eigen::Isometry3d poseOf(const Eigen::Matrix3d& R, const Eigen::Vector3d& position) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = R;
  T.translation() = position;
  return T;
}

Eigen::Isometry3d poseFromYaw(const Eigen::Vector3d& position, double yaw_rad) {
  return poseOf(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix(), position);
}

Eigen::Isometry3d interpolated(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b,
                               double share) {
  return poseOf(Eigen::Quaterniond(a.linear())
                    .slerp(share, Eigen::Quaterniond(b.linear()))
                    .toRotationMatrix(),
                (1 - share) * a.translation() + share * b.translation());
}

std::vector<double> pathLengths(const std::vector<Eigen::Isometry3d>& poses) {
  std::vector<double> way{0};
  for (std::size_t i = 1; i < poses.size(); ++i)
    way.push_back(way.back() + (poses[i].translation() - poses[i - 1].translation()).norm());
  return way;
}

double rotationBetween(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return Eigen::Quaterniond(a.linear()).angularDistance(Eigen::Quaterniond(b.linear()));
}

double angleDifference(double a_rad, double b_rad) {
  return std::remainder(a_rad - b_rad, 2 * M_PI);
}

Eigen::Matrix3d orthonormalized(const Eigen::Matrix3d& R) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d U = svd.matrixU();
  if ((U * svd.matrixV().transpose()).determinant() < 0) U.col(2) = -U.col(2);
  return U * svd.matrixV().transpose();
}

bool isRigid(const Eigen::Matrix4d& T, double tolerance) {
  if (!T.allFinite()) return false;
  const Eigen::Matrix3d R = T.topLeftCorner<3, 3>();
  const Eigen::RowVector4d last = T.row(3);
  return (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() <= tolerance &&
         R.determinant() > 0 &&
         (last - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() <= tolerance;
}

}  // namespace xview
