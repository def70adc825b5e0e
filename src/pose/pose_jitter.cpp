// SPDX-License-Identifier: BSD-3-Clause
#include "pose_jitter.h"

#include <Eigen/LU>
#include <algorithm>
#include <initializer_list>

namespace xview {
namespace {

constexpr int kFewestBlocks = 6;
/// Jitter beyond which a pose is not asked: keeps what its points leave open from being taken for
/// jitter.
constexpr double kWidest_m = 0.05, kWidest_rad = 0.005;
/// Points pull at a pose that much less than it is off, because other distributions become the
/// nearest ones: across level ground less so. Measured on simulated jitter and drift.
constexpr double kGivesWay = 3, kGivesWayOnGround = 2.25;

using AxisSums = Eigen::Array<double, 6, 1>;

double share(const AxisSums& excess, const AxisSums& answer, std::initializer_list<int> axes,
             double gives_way) {
  double above = 0, below = 0;
  for (const int axis : axes) {
    above += excess(axis);
    below += answer(axis);
  }
  return below > 0 ? gives_way * gives_way * std::max(0.0, above / below) : 0;
}

}  // namespace

Vector6d poseJitter(const std::vector<PosePull>& poses) {
  Vector6d widest;
  widest << Eigen::Vector3d::Constant(1 / (kWidest_m * kWidest_m)),
      Eigen::Vector3d::Constant(1 / (kWidest_rad * kWidest_rad));
  AxisSums excess = AxisSums::Zero(), answer = AxisSums::Zero();
  for (const PosePull& pose : poses) {
    if (pose.blocks < kFewestBlocks) continue;
    const Matrix6d least = pose.information + Matrix6d(widest.asDiagonal());
    const Matrix6d gain = least.inverse();
    excess += (gain * pose.pull).array().square() -
              (gain * pose.of_blocks * gain.transpose()).diagonal().array();
    answer += (gain * pose.information).diagonal().array().square();
  }
  Vector6d variances;
  variances.head<2>().setConstant(share(excess, answer, {0, 1}, kGivesWay));
  variances(2) = share(excess, answer, {2}, kGivesWayOnGround);
  variances.segment<2>(3).setConstant(share(excess, answer, {3, 4}, kGivesWayOnGround));
  variances(5) = share(excess, answer, {5}, kGivesWay);
  return variances;
}

}  // namespace xview
