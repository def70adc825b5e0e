// SPDX-License-Identifier: BSD-3-Clause
#include "pose/refine.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "base/median.h"
#include "registration.h"

namespace xview::pose {
namespace {

constexpr int kIterations = 20;
/// Share of the drift of the options that the prior has where a window shows none.
constexpr double kSteady = 0.4;
/// Factor on the tolerance of residuals at first where the window may drift: points may be off by
/// some 2 m.
constexpr double kTolerance = 30;
constexpr double kFewestOfGroup = 5;  ///< points of a kind for it to agree or not
/// The null inlier ratio is measured with some of the points at kMoves poses, kMove_m off.
constexpr int kMoves = 6;
constexpr double kMove_m = 3;
constexpr std::size_t kOfMovedPoints = 3;
constexpr double kClearlyBetter = 50;  ///< by this the cost must be lower with drift

// What the covariance is made of: how far each kind of error reaches the pose through the fit. Set
// by maximum likelihood on accepted windows of simulated towns with clean and with noisy depth,
// with and without added drift, and of scanners.

/// Factor on the spread of blocks, whose points err together.
constexpr double kPoints = 0.65;
/// Offset between the sides of objects that query and map observed, common to a kind of objects.
constexpr double kSide_m = 0.037;
/// Factors on the drift and the turn of the prior, and one more where a window shows drift.
constexpr double kDrift = 0.4, kDriftTurn = 0.2, kShownDrift = 4;
/// Standard deviation of depths at which all these variances are doubled.
constexpr double kKnownWell_m = 0.1;
/// Weight of a point relative to an independent one at which the variances are doubled; below it
/// they grow quickly. Points of scans that were bent by motion have less.
constexpr double kBent = 0.033;
/// Share of the typical error of points that all of them have in common, in the plane.
constexpr double kCommon = 0.03;
/// Factor on the standard deviation of the given pose over that of its prior.
constexpr double kGiven = 2;
constexpr double kMoreWeight = 3000;  ///< see covarianceLeftOpen
/// Share of the spread of the poses that the starts converge to, along a street without landmarks.
constexpr double kStarts = 0.7;
constexpr double kFloor_m = 0.0005, kFloor_rad = 0.00008;
/// Errors of single poses, as by motion while a scanner turns: vehicles pitch and roll meanwhile.
constexpr double kSinglePose_m = 0.001, kSinglePoseUp_m = 0.0025;
constexpr double kSinglePose_rad = 0.00012, kSinglePoseTilt_rad = 0.0009;

using Matrix6Xd = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// Pull of a point at the last sensor, as if the window were one rigid body.
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

/// Vector between the two observed sides of an object, in the plane: ground has one side.
Eigen::Vector3d fromSideToSide(const Partner& partner) {
  if (partner.view.isZero() || partner.map_view.isZero()) return Eigen::Vector3d::Zero();
  const Eigen::Vector3d between = partner.map_view - partner.view;
  return {between.x(), between.y(), 0};
}

PulledFit pulledFit(const Registration& registration, const std::vector<QueryPoint>& points,
                    const Estimate& at) {
  PulledFit fit{Evidence(registration.poseCount()), {}, {}, {}, {}, {}};
  fit.priors = registration.assemble(fit.evidence, at);
  registration.forPartners(
      points, at, registration.lastScope(), [&](const QueryPoint& q, const Partner& partner) {
        fit.evidence.add(q, partner);
        const Eigen::Matrix<double, 6, 3> weighted = registration.pointWeight() * partner.JW;
        fit.pulls.push_back({&q, weighted * partner.r, weighted * fromSideToSide(partner)});
      });
  fit.all = registration.assemble(fit.evidence, at);
  fit.last_rows =
      fit.all.H.ldlt().solve(Eigen::MatrixXd::Identity(fit.all.H.rows(), 6)).transpose();
  fit.response.assign(registration.poseCount(), fit.last_rows.leftCols<6>());
  for (std::size_t pose = 0; pose < fit.response.size(); ++pose) {
    for (const auto& [row, share] : registration.drift().sharesOf(pose))
      fit.response[pose] += share * fit.last_rows.middleCols<6>(6 + row);
  }
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
  return kPoints * kPoints * count / std::max(1.0, count - 6) * sumOfSquares(blocks);
}

/// All objects of a kind have about the same depth.
Matrix6d covarianceOfSides(const PulledFit& fit) {
  std::map<std::uint32_t, Vector6d> kinds;
  for (const Pull& pull : fit.pulls)
    kinds.try_emplace(pull.point->group, Vector6d::Zero()).first->second +=
        fit.response[pull.point->pose] * pull.side;
  return kSide_m * kSide_m * sumOfSquares(kinds);
}

/// The priors hold the drift at zero, whatever it is.
Matrix6d covarianceOfDrift(const PulledFit& fit, const DriftChain& chain, bool shown) {
  Matrix6d covariance = Matrix6d::Zero();
  if (chain.size() == 0) return covariance;
  const Matrix6Xd held = fit.last_rows.rightCols(chain.size());
  const double scale = shown ? kShownDrift : 1;
  for (const auto& [axis, drift] :
       {std::pair(0, kDrift), std::pair(1, kDrift), std::pair(5, kDriftTurn)})
    covariance += std::pow(scale * drift, 2) * held * chain.informationOf(axis) * held.transpose();
  return covariance;
}

/// Share of the error of the given pose in the plane, kGiven times that of its prior.
Matrix6d covarianceOfGivenPose(const PulledFit& fit) {
  Vector6d prior = fit.priors.H.diagonal().head<6>();
  prior.segment<3>(2).setZero();
  const Matrix6d held = fit.last_rows.leftCols<6>();
  return kGiven * kGiven * held * prior.asDiagonal() * held.transpose();
}

/// Covariance that remains if every point weighed kMoreWeight times more: the prior's share.
Matrix6d covarianceLeftOpen(const PulledFit& fit) {
  const Eigen::MatrixXd H = kMoreWeight * fit.all.H + (1 - kMoreWeight) * fit.priors.H;
  const Eigen::MatrixXd least = H.ldlt().solve(Eigen::MatrixXd::Identity(H.rows(), 6));
  return least.topRows<6>();
}

/// `own_to_last`: by pose, turns an increment about its sensor into one about the last sensor.
std::vector<PosePull> posePulls(const PulledFit& fit, const std::vector<Matrix6d>& own_to_last,
                                double point_weight) {
  std::vector<PosePull> poses(own_to_last.size());
  std::map<std::pair<std::size_t, Block>, Vector6d> blocks;
  for (const Pull& pull : fit.pulls)
    blocks.try_emplace({pull.point->pose, blockOf(*pull.point)}, Vector6d::Zero()).first->second +=
        pull.away;
  for (const auto& [key, away] : blocks) {
    PosePull& pose = poses[key.first];
    const Vector6d pull = own_to_last[key.first].transpose() * away;
    pose.pull += pull;
    pose.of_blocks += pull * pull.transpose();
    ++pose.blocks;
  }
  for (std::size_t i = 0; i < poses.size(); ++i)
    poses[i].information =
        point_weight * own_to_last[i].transpose() * fit.evidence.poses[i].H * own_to_last[i];
  return poses;
}

/// Jitter is the independent error of each pose. That of the last pose adds to its covariance
/// directly, minus the part that moved the fit.
Matrix6d covarianceOfJitter(const PulledFit& fit, const Registration& registration,
                            const Estimate& at) {
  std::vector<Matrix6d> own_to_last(registration.poseCount(), Matrix6d::Identity());
  for (std::size_t pose = 0; pose < own_to_last.size(); ++pose)
    own_to_last[pose].topRightCorner<3, 3>() =
        crossFromRight(registration.sensorOf(at) - registration.sensorAt(at, pose));
  const double weight = registration.pointWeight();
  const Vector6d jitter = poseJitter(posePulls(fit, own_to_last, weight));
  Matrix6d covariance = Matrix6d::Zero();
  for (std::size_t pose = 0; pose < own_to_last.size(); ++pose) {
    Matrix6d moved = weight * fit.response[pose] * fit.evidence.poses[pose].H * own_to_last[pose];
    if (pose + 1 == own_to_last.size()) moved -= Matrix6d::Identity();
    covariance += moved * jitter.asDiagonal() * moved.transpose();
  }
  return covariance;
}

/// A window under one prior of its drift.
struct Fit {
  Registration registration;
  Registration::Descent descent;
  double cost = INFINITY;  ///< of the points, without that of the priors
};

void descend(const std::vector<QueryPoint>& points, const Estimate& start, int iterations,
             Fit& fit) {
  fit.descent = fit.registration.descend(points, start, iterations, true);
  if (!fit.descent.valid) return;
  const Scope scope = fit.registration.lastScope();
  fit.cost = fit.registration.evidenceAt(fit.descent.at, points, scope).cost;
}

/// Covariance of the last pose. `start_open`: where starts to both sides end. `sigma_m`: typical
/// error of points. `drifts`: the window was found to drift as much as the options allow.
Matrix6d covarianceOf(const Fit& fit, const Eigen::Matrix3d& start_open,
                      const std::vector<QueryPoint>& points, double sigma_m, bool drifts) {
  const Registration& registration = fit.registration;
  const PulledFit pulled = pulledFit(registration, points, fit.descent.at);
  const double known = 1 + std::pow(sigma_m / kKnownWell_m, 2);
  const double bent = 1 + std::pow(kBent / registration.pointWeight(), 4);
  Matrix6d covariance = known * bent *
                            (covarianceOfPoints(pulled) + covarianceOfSides(pulled) +
                             covarianceOfDrift(pulled, registration.drift(), drifts)) +
                        covarianceOfGivenPose(pulled) + covarianceLeftOpen(pulled) +
                        covarianceOfJitter(pulled, registration, fit.descent.at);
  const double poses = std::sqrt(static_cast<double>(registration.poseCount()));
  const auto floor = [&](double always, double single) {
    return always * always + std::pow(single / poses, 2);
  };
  Vector6d floors;
  floors << Eigen::Vector2d::Constant(floor(kFloor_m, kSinglePose_m)),
      floor(kFloor_m, kSinglePoseUp_m),
      Eigen::Vector2d::Constant(floor(kFloor_rad, kSinglePoseTilt_rad)),
      floor(kFloor_rad, kSinglePose_rad);
  covariance.diagonal() += floors;
  covariance.topLeftCorner<3, 3>() += kStarts * kStarts * start_open;
  covariance.diagonal().head<2>().array() += std::pow(kCommon * sigma_m, 2);
  return 0.5 * (covariance + covariance.transpose());
}

/// The points of one group that lie where the map holds anything, or some of them.
struct GroupAgreement {
  double points = 0, found = 0, null_inlier_ratio = 0;
};

/// Adds how much the points agree at a pose; a point agrees as much as it counts in the fit.
void addAgreement(const Registration& registration, const std::vector<QueryPoint>& points,
                  const Estimate& at, double weight, double GroupAgreement::*sum,
                  std::map<std::uint32_t, GroupAgreement>& groups) {
  registration.forPartners(points, at, registration.lastScope(),
                           [&](const QueryPoint& q, const Partner& partner) {
                             const auto group = groups.find(q.group);
                             if (group != groups.end())
                               group->second.*sum += weight / (1 + partner.mahalanobis / 4);
                           });
}

std::optional<Agreement> agreementOf(const DistributionMap& map,
                                     const std::vector<QueryPoint>& points,
                                     const Registration& registration, const Estimate& at) {
  std::map<std::uint32_t, GroupAgreement> groups;
  std::size_t held = 0;
  for (const QueryPoint& q : points) {
    if (isGround(kindOfGroup(q.group))) continue;
    if (!map.holdsAnything((at.T_map_query * q.p - map.origin()).cast<float>())) continue;
    groups[q.group].points += 1;
    ++held;
  }
  if (held < kFewestPartners) return std::nullopt;
  addAgreement(registration, points, at, 1, &GroupAgreement::found, groups);
  const std::vector<QueryPoint> some = evenlySpread(points, points.size() / kOfMovedPoints);
  const double weight = static_cast<double>(points.size()) / static_cast<double>(some.size());
  for (int k = 0; k < kMoves; ++k) {
    Estimate moved = at;
    const double angle = 0.3 + 2 * M_PI * k / kMoves;
    moved.T_map_query.pretranslate(kMove_m * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0));
    addAgreement(registration, some, moved, weight / kMoves, &GroupAgreement::null_inlier_ratio,
                 groups);
  }
  Agreement sum;
  double weights = 0;
  for (const auto& [id, group] : groups) {
    if (group.points < kFewestOfGroup) continue;
    const double root = std::sqrt(group.points);
    sum.found += group.found / root;
    sum.null_inlier_ratio += group.null_inlier_ratio / root;
    weights += root;
  }
  if (!(weights > 0)) return std::nullopt;
  return Agreement{std::min(1.0, sum.found / weights),
                   std::min(1.0, sum.null_inlier_ratio / weights)};
}

}  // namespace

Refinement refine(const DistributionMap& map, const RefineQuery& query, const LabelSet& labels,
                  const Eigen::Isometry3d& T_map_query, const RefineOptions& options) {
  Refinement result;
  result.T_map_query = T_map_query;
  const std::vector<QueryPoint> points = choosePoints(query, labels, options.model.max_points);
  if (points.size() < kFewestPartners) return result;

  Fit steady{{map, query, T_map_query, points, options, {kSteady, 1}}, {}};
  const Registration::Start start = steady.registration.multiStart(points);
  descend(points, start.at, 1 + 2 * kIterations / 3, steady);

  Fit drifting{{map, query, T_map_query, points, options, {1, kTolerance}}, {}};
  Estimate undrifted = drifting.registration.start();
  undrifted.T_map_query = start.at.T_map_query;
  if (drifting.registration.drift().size() > 0) descend(points, undrifted, kIterations, drifting);

  const bool drifts = drifting.descent.valid &&
                      (!steady.descent.valid || steady.cost - drifting.cost > kClearlyBetter);
  const Fit& best = drifts ? drifting : steady;
  const Registration::Descent& d = best.descent;
  if (!d.valid) return result;
  result.T_map_query = d.at.T_map_query;
  for (std::size_t pose = 0; pose < query.poses.size(); ++pose)
    result.T_map_query_at.push_back(best.registration.poseAt(d.at, pose));
  result.agreement = agreementOf(map, points, best.registration, d.at);
  // The noise of the map is there where that of the query is not known, too.
  const double sigma_m = std::hypot(query.cloud.typicalSigma(), map.noise_m());
  result.covariance = covarianceOf(best, start.open, points, sigma_m, drifts);
  const Eigen::Vector3d sensor = query.poses.back().translation();
  const Eigen::Vector3d given = T_map_query * sensor + start.rise_m * Eigen::Vector3d::UnitZ();
  const double shift_m = (result.T_map_query * sensor - given).norm();
  result.converged = shift_m <= options.max_shift_m;
  return result;
}

std::optional<double> selfConsistency(const RefineQuery& query, const LabelSet& labels,
                                      const RefineOptions& options) {
  std::array<LabelledCloud, 2> halves;
  for (LabelledCloud& half : halves) half.origin = query.cloud.origin;
  for (std::size_t i = 0; i < query.cloud.size(); ++i) {
    const Point& point = query.cloud.points[i];
    const std::size_t turn = query.poses.size() > 1 ? point.view : i;
    halves[turn % 2].points.push_back(point);
  }
  if (halves[0].empty() || halves[1].empty()) return std::nullopt;
  const DistributionMap map(std::move(halves[0]), labels, query.poses, options);
  const RefineQuery other{halves[1], query.poses};
  const std::vector<QueryPoint> points = choosePoints(other, labels, options.model.max_points);
  const Registration registration(map, other, Eigen::Isometry3d::Identity(), points, options,
                                  {kSteady, 1});
  const auto agreement = agreementOf(map, points, registration, registration.start());
  return agreement ? std::optional(agreement->found) : std::nullopt;
}

}  // namespace xview::pose
