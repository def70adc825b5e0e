// SPDX-License-Identifier: BSD-3-Clause
#include "odometry_errors.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <initializer_list>

namespace xview::pose {
namespace {

constexpr double kPiece_m = 5;
constexpr Eigen::Index kMostKnots = 12;
constexpr double kShortest_m = 0.1;  ///< a robot that stood still has not drifted
constexpr double kSlow = 0.8;        ///< share of the variance that keeps its value over kMemory_m
constexpr double kMemory_m = 60;
constexpr double kWalk_m =
    40;  ///< path length after which the random walk has its share of the variance
constexpr double kLeastTurn = 1e-6;  ///< [rad/m]

/// The sensor at a way from the last one.
Eigen::Vector3d sensorAt(double way_m, const std::vector<double>& ways_m,
                         const std::vector<Eigen::Vector3d>& sensors) {
  std::size_t i = ways_m.size() - 1;
  while (i > 0 && ways_m[i] < way_m) --i;
  return sensors[i];
}

/// Of the errors of the pieces in one axis, if the rate is 1.
Eigen::MatrixXd covarianceOfPieces(Eigen::Index pieces, double piece_m) {
  Eigen::MatrixXd covariance(pieces, pieces);
  for (Eigen::Index k = 0; k < pieces; ++k) {
    for (Eigen::Index l = 0; l < pieces; ++l) {
      const double apart_m = std::abs(static_cast<double>(k - l)) * piece_m;
      covariance(k, l) = kSlow * piece_m * piece_m * std::exp(-apart_m / kMemory_m) +
                         (k == l ? (1 - kSlow) * piece_m * kWalk_m : 0);
    }
  }
  return covariance;
}

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

Eigen::Matrix3d crossFromRight(const Eigen::Vector3d& v) {
  return (Eigen::Matrix3d() << 0, v.z(), -v.y(), -v.z(), 0, v.x(), v.y(), -v.x(), 0).finished();
}

DriftChain::DriftChain(const std::vector<double>& ways_m,
                       const std::vector<Eigen::Vector3d>& sensors, double reach_m,
                       const Rates& rates)
    : shares_(ways_m.size()) {
  reach_m = std::min(reach_m, ways_m.front());
  if (!(reach_m > kShortest_m) || !(rates.share > 0)) return;
  const auto pieces = std::clamp<Eigen::Index>(
      static_cast<Eigen::Index>(std::ceil(reach_m / kPiece_m)), 1, kMostKnots);
  const double piece_m = reach_m / static_cast<double>(pieces);
  for (std::size_t i = 0; i < ways_m.size(); ++i) {
    const double position = std::min(ways_m[i], reach_m) / piece_m;
    const Eigen::Index piece = std::min(static_cast<Eigen::Index>(position), pieces - 1);
    const double share = position - static_cast<double>(piece);
    shares_[i].push_back({6 * piece, share});
    if (piece > 0) shares_[i].push_back({6 * piece - 6, 1 - share});
  }

  of_pieces_ =
      covarianceOfPieces(pieces, piece_m).llt().solve(Eigen::MatrixXd::Identity(pieces, pieces));
  const double turn = std::max(rates.turn_per_m, kLeastTurn);
  Vector6d rate;
  rate << Eigen::Vector3d::Constant(rates.share), Eigen::Vector3d::Constant(turn);
  differences_.fill(Eigen::MatrixXd::Zero(pieces, 6 * pieces));
  for (Eigen::Index k = 0; k < pieces; ++k) {
    // A piece turns about its middle.
    const double middle_m = (static_cast<double>(k) + 0.5) * piece_m;
    Matrix6d about_middle = Matrix6d::Identity();
    about_middle.topRightCorner<3, 3>() = crossFromRight(sensorAt(middle_m, ways_m, sensors));
    for (Eigen::Index axis = 0; axis < 6; ++axis) {
      Eigen::MatrixXd& difference = differences_[static_cast<std::size_t>(axis)];
      difference.block<1, 6>(k, 6 * k) = about_middle.row(axis) / rate(axis);
      if (k > 0) difference.block<1, 6>(k, 6 * k - 6) = -about_middle.row(axis) / rate(axis);
    }
  }
  information_ = Eigen::MatrixXd::Zero(6 * pieces, 6 * pieces);
  for (Eigen::Index axis = 0; axis < 6; ++axis) information_ += informationOf(axis);
}

Eigen::MatrixXd DriftChain::informationOf(Eigen::Index axis) const {
  const Eigen::MatrixXd& difference = differences_[static_cast<std::size_t>(axis)];
  return difference.transpose() * of_pieces_ * difference;
}

Vector6d DriftChain::errorOf(std::size_t pose, const Eigen::VectorXd& errors) const {
  Vector6d error = Vector6d::Zero();
  for (const auto& [row, share] : sharesOf(pose)) error += share * errors.segment<6>(row);
  return error;
}

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

}  // namespace xview::pose
