// SPDX-License-Identifier: BSD-3-Clause
#include "drift_chain.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace xview {
namespace {

constexpr double kPiece_m = 5;
constexpr std::size_t kMostKnots = 12;
constexpr double kShortest_m = 0.1;  ///< a robot that stood still has not drifted
constexpr double kSlow = 0.8;        ///< share of the variance that keeps its value over kMemory_m
constexpr double kMemory_m = 60;
constexpr double kWalk_m = 40;  ///< after so much way the random walk has its share of the variance
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

}  // namespace

Eigen::Matrix3d crossFromRight(const Eigen::Vector3d& v) {
  return (Eigen::Matrix3d() << 0, v.z(), -v.y(), -v.z(), 0, v.x(), v.y(), -v.x(), 0).finished();
}

DriftChain::DriftChain(const std::vector<double>& ways_m,
                       const std::vector<Eigen::Vector3d>& sensors, double reach_m,
                       const Rates& rates)
    : places_(ways_m.size()) {
  reach_m = std::min(reach_m, ways_m.front());
  if (!(reach_m > kShortest_m) || !(rates.share > 0)) return;
  knots_ = std::clamp<std::size_t>(static_cast<std::size_t>(std::ceil(reach_m / kPiece_m)), 1,
                                   kMostKnots);
  const double piece_m = reach_m / static_cast<double>(knots_);
  for (std::size_t i = 0; i < ways_m.size(); ++i) {
    const double position = std::min(ways_m[i], reach_m) / piece_m;
    const std::size_t knot = std::min(static_cast<std::size_t>(position), knots_ - 1);
    places_[i] = {knot, position - static_cast<double>(knot)};
  }

  const auto pieces = static_cast<Eigen::Index>(knots_);
  of_pieces_ =
      covarianceOfPieces(pieces, piece_m).llt().solve(Eigen::MatrixXd::Identity(pieces, pieces));
  const double turn = std::max(rates.turn_per_m, kLeastTurn);
  Vector6d rate;
  rate << Eigen::Vector3d::Constant(rates.share), Eigen::Vector3d::Constant(turn);
  differences_.fill(Eigen::MatrixXd::Zero(pieces, size()));
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
  information_ = Eigen::MatrixXd::Zero(size(), size());
  for (Eigen::Index axis = 0; axis < 6; ++axis) information_ += informationOf(axis);
}

Eigen::MatrixXd DriftChain::informationOf(Eigen::Index axis) const {
  const Eigen::MatrixXd& difference = differences_[static_cast<std::size_t>(axis)];
  return difference.transpose() * of_pieces_ * difference;
}

Vector6d DriftChain::at(const Place& place, const Eigen::VectorXd& errors) const {
  if (knots_ == 0) return Vector6d::Zero();
  const auto next = static_cast<Eigen::Index>(6 * place.knot);
  Vector6d error = place.share * errors.segment<6>(next);
  if (place.knot > 0) error += (1 - place.share) * errors.segment<6>(next - 6);
  return error;
}

}  // namespace xview
