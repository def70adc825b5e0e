// SPDX-License-Identifier: BSD-3-Clause
#include "fit_errors.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "pose_jitter.h"

namespace xview {
namespace {

using E = RefinementErrors;
using Matrix6Xd = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// How far a point pulls at the last sensor, one rigid body.
struct Pull {
  const QueryPoint* point;
  Vector6d away;  ///< from where it is to its distribution
  Vector6d side;  ///< from the side that the query saw to the side that the map knows, per metre
};

/// A fit and what pulls at it.
struct PulledFit {
  Evidence evidence;
  std::vector<Pull> pulls;
  NormalEquations all, priors;
  std::vector<Matrix6d> response;  ///< of the last pose to a pull at what one pose saw
  Matrix6Xd last_rows;             ///< of the inverse of all.H, those of the last pose
};

Eigen::Vector3d level(const Eigen::Vector3d& v) { return {v.x(), v.y(), 0}; }

/// What both sides of a thing have between them is a matter of the plane: ground has one side.
Eigen::Vector3d fromSideToSide(const Partner& partner) {
  if (partner.view.isZero() || partner.map_view.isZero()) return Eigen::Vector3d::Zero();
  return level(partner.map_view - partner.view);
}

std::vector<Matrix6d> responses(const Matrix6Xd& last_rows, const Registration& registration) {
  const DriftChain& chain = registration.chain();
  std::vector<Matrix6d> responses(registration.poseCount(), last_rows.leftCols<6>());
  for (std::size_t pose = 0; pose < responses.size() && chain.knots() > 0; ++pose) {
    const DriftChain::Place& place = chain.placeOf(pose);
    const auto next = static_cast<Eigen::Index>(6 + 6 * place.knot);
    responses[pose] += place.share * last_rows.middleCols<6>(next);
    if (place.knot > 0) responses[pose] += (1 - place.share) * last_rows.middleCols<6>(next - 6);
  }
  return responses;
}

PulledFit pulledFit(const Registration& registration, const std::vector<QueryPoint>& points,
                    const Estimate& at) {
  PulledFit fit;
  fit.evidence.poses.resize(registration.poseCount());
  fit.priors = registration.assemble(fit.evidence, at);
  registration.forPartners(
      points, at, registration.lastScope(), [&](const QueryPoint& q, const Partner& partner) {
        fit.evidence.add(q, partner);
        const Eigen::Matrix<double, 6, 3> trusted = registration.trust() * partner.JW;
        fit.pulls.push_back({&q, trusted * partner.r, trusted * fromSideToSide(partner)});
      });
  fit.all = registration.assemble(fit.evidence, at);
  fit.last_rows =
      fit.all.H.ldlt().solve(Eigen::MatrixXd::Identity(fit.all.H.rows(), 6)).transpose();
  fit.response = responses(fit.last_rows, registration);
  return fit;
}

template <class Key>
Matrix6d sumOfSquares(const std::map<Key, Vector6d>& sums) {
  Matrix6d squares = Matrix6d::Zero();
  for (const auto& [key, sum] : sums) squares += sum * sum.transpose();
  return squares;
}

/// Points of one block err together; six of the blocks went into the pose.
Matrix6d covarianceOfPoints(const PulledFit& fit) {
  std::map<Block, Vector6d> blocks;
  for (const Pull& pull : fit.pulls)
    blocks.try_emplace(blockOf(*pull.point), Vector6d::Zero()).first->second +=
        fit.response[pull.point->pose] * pull.away;
  const auto count = static_cast<double>(blocks.size());
  return E::kPoints * E::kPoints * count / std::max(1.0, count - 6) * sumOfSquares(blocks);
}

/// All things of a kind have about the same depth.
Matrix6d covarianceOfSides(const PulledFit& fit) {
  std::map<std::uint32_t, Vector6d> kinds;
  for (const Pull& pull : fit.pulls)
    kinds.try_emplace(pull.point->group, Vector6d::Zero()).first->second +=
        fit.response[pull.point->pose] * pull.side;
  return E::kSide_m * E::kSide_m * sumOfSquares(kinds);
}

/// The priors hold the drift at zero, against what it is.
Matrix6d covarianceOfDrift(const PulledFit& fit, const Registration& registration, bool shown) {
  Matrix6d covariance = Matrix6d::Zero();
  const DriftChain& chain = registration.chain();
  if (chain.knots() == 0) return covariance;
  const Matrix6Xd held = fit.last_rows.rightCols(chain.size());
  const double scale = shown ? E::kShownDrift : 1;
  for (const auto& [axis, drift] :
       {std::pair(0, E::kDrift), std::pair(1, E::kDrift), std::pair(5, E::kDriftTurn)})
    covariance += std::pow(scale * drift, 2) * held * chain.informationOf(axis) * held.transpose();
  return covariance;
}

/// The given pose is right in the plane to its trust, or so much worse.
Matrix6d covarianceOfGivenPose(const PulledFit& fit) {
  Vector6d trusted = fit.priors.H.diagonal().head<6>();
  trusted.segment<3>(2).setZero();
  const Matrix6d held = fit.last_rows.leftCols<6>();
  return E::kGiven * E::kGiven * held * trusted.asDiagonal() * held.transpose();
}

/// What is open where points that are worth much more would say nothing.
Matrix6d covarianceLeftOpen(const PulledFit& fit) {
  const Eigen::MatrixXd H = E::kWorth * fit.all.H + (1 - E::kWorth) * fit.priors.H;
  const Eigen::MatrixXd least = H.ldlt().solve(Eigen::MatrixXd::Identity(H.rows(), 6));
  return least.topRows<6>();
}

/// Turns an increment of a pose about its own sensor into one about the last sensor.
Matrix6d aboutOwnSensor(const Registration& registration, const Estimate& at, std::size_t pose) {
  Matrix6d turn = Matrix6d::Identity();
  turn.topRightCorner<3, 3>() =
      crossFromRight(registration.sensorOf(at) - registration.sensorAt(at, pose));
  return turn;
}

std::vector<PosePull> posePulls(const PulledFit& fit, const std::vector<Matrix6d>& about_own,
                                double trust) {
  std::vector<PosePull> poses(about_own.size());
  std::map<std::pair<std::size_t, Block>, Vector6d> blocks;
  for (const Pull& pull : fit.pulls)
    blocks.try_emplace({pull.point->pose, blockOf(*pull.point)}, Vector6d::Zero()).first->second +=
        pull.away;
  for (const auto& [key, away] : blocks) {
    PosePull& pose = poses[key.first];
    const Vector6d pull = about_own[key.first].transpose() * away;
    pose.pull += pull;
    pose.of_blocks += pull * pull.transpose();
    ++pose.blocks;
  }
  for (std::size_t i = 0; i < poses.size(); ++i)
    poses[i].information =
        trust * about_own[i].transpose() * fit.evidence.poses[i].H * about_own[i];
  return poses;
}

/// Every pose errs by its own jitter; that of the last one is its error, but for what it moved the
/// fit.
Matrix6d covarianceOfJitter(const PulledFit& fit, const Registration& registration,
                            const Estimate& at) {
  std::vector<Matrix6d> about_own;
  for (std::size_t pose = 0; pose < registration.poseCount(); ++pose)
    about_own.push_back(aboutOwnSensor(registration, at, pose));
  const double trust = registration.trust();
  const Vector6d jitter = poseJitter(posePulls(fit, about_own, trust));
  Matrix6d covariance = Matrix6d::Zero();
  for (std::size_t pose = 0; pose < about_own.size(); ++pose) {
    Matrix6d moved = trust * fit.response[pose] * fit.evidence.poses[pose].H * about_own[pose];
    if (pose + 1 == about_own.size()) moved -= Matrix6d::Identity();
    covariance += moved * jitter.asDiagonal() * moved.transpose();
  }
  return covariance;
}

}  // namespace

Matrix6d fitCovariance(const Registration& registration, const std::vector<QueryPoint>& points,
                       const Estimate& at, double sigma_m, bool drift_shown) {
  const PulledFit fit = pulledFit(registration, points, at);
  const double known = 1 + std::pow(sigma_m / E::kKnownWell_m, 2);
  const double bent = 1 + std::pow(E::kBent / registration.trust(), 4);
  return known * bent *
             (covarianceOfPoints(fit) + covarianceOfSides(fit) +
              covarianceOfDrift(fit, registration, drift_shown)) +
         covarianceOfGivenPose(fit) + covarianceLeftOpen(fit) +
         covarianceOfJitter(fit, registration, at);
}

}  // namespace xview
