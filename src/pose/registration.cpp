// SPDX-License-Identifier: BSD-3-Clause
#include "registration.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>

namespace xview {
namespace {

constexpr double kRadians = M_PI / 180;
constexpr double kCorrelatedPoints = 20;  ///< so many points err like one, before it is measured
constexpr double kSameSide = -0.3;  ///< cosine between views that see the same side of a thing
constexpr double kOtherSideWeight = 0.1;
/// Pulls of blocks spread by so much more than their scatter shows: their points have more in
/// common.
constexpr double kBlocksAlike = 40;
constexpr double kLeastExcess = 1e-3, kMostExcess = 1e3;

Eigen::Isometry3d turnedAbout(const Eigen::Vector3d& about, const Vector6d& by) {
  const Eigen::Vector3d turn = by.tail<3>();
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  if (turn.norm() > 1e-15)
    motion.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  motion.translation() = about - motion.linear() * about + by.head<3>();
  return motion;
}

/// Where a start leads to.
struct Arrival {
  Estimate at;
  Eigen::Vector3d sensor;
  double cost;  ///< -2 log likelihood
};

Registration::Start meanOf(const std::vector<Arrival>& arrivals) {
  const auto by_cost = [](const Arrival& a, const Arrival& b) { return a.cost < b.cost; };
  const Arrival& best = *std::min_element(arrivals.begin(), arrivals.end(), by_cost);
  double weight = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (const Arrival& a : arrivals) {
    const double likelihood = std::exp(0.5 * (best.cost - a.cost));
    Eigen::Vector3d away = a.sensor - best.sensor;
    away.z() = 0;
    weight += likelihood;
    sum += likelihood * away;
    squares += likelihood * away * away.transpose();
  }
  const Eigen::Vector3d mean = sum / weight;
  Registration::Start start{best.at, squares / weight - mean * mean.transpose()};
  start.at.T_map_query.pretranslate(mean);
  return start;
}

}  // namespace

Registration::Registration(const DistributionMap& map, const RefineQuery& query,
                           const Eigen::Isometry3d& T_map_query,
                           const std::vector<QueryPoint>& points, const RefineOptions& options,
                           const Presumption& presumption)
    : cells_(DistributionCells::of(map)),
      poses_(query.poses),
      sensor_in_query_(query.poses.back().translation()),
      up_in_query_(T_map_query.linear().transpose().col(2)),
      given_(T_map_query),
      options_(options),
      presumption_(presumption),
      chain_(chainOf(points)),
      trust_(1 / kCorrelatedPoints) {}

DriftChain Registration::chainOf(const std::vector<QueryPoint>& points) const {
  const std::vector<double> ways = waysToLast(poses_);
  double reach_m = 0;
  for (const QueryPoint& q : points) reach_m = std::max(reach_m, ways[q.pose]);
  std::vector<Eigen::Vector3d> sensors;
  for (const Eigen::Isometry3d& T : poses_)
    sensors.push_back(given_.linear() * (T.translation() - sensor_in_query_));
  return DriftChain(ways, sensors, reach_m,
                    {presumption_.drift * options_.drift_share,
                     presumption_.drift * options_.drift_deg_per_m * kRadians});
}

/// Takes what was seen from a pose to the map.
Eigen::Isometry3d Registration::poseAt(const Estimate& at, std::size_t pose) const {
  if (chain_.knots() == 0) return at.T_map_query;
  return turnedAbout(sensorOf(at), chain_.at(chain_.placeOf(pose), at.drift)) * at.T_map_query;
}

bool Registration::findPartner(const QueryPoint& q, const Eigen::Isometry3d& T,
                               const Eigen::Vector3d& about, const Scope& scope,
                               Partner& partner) const {
  const Eigen::Vector3d p = T * q.p;
  const Distribution* d = cells_.nearest((p - cells_.origin()).cast<float>(), q.group,
                                         static_cast<float>(scope.gate_m));
  if (!d) return false;
  partner.r = cells_.origin() + d->mean.cast<double>() - p;
  const Eigen::Matrix3d W = d->information.cast<double>();
  partner.mahalanobis = partner.r.dot(W * partner.r);
  partner.view = T.linear() * q.view;
  partner.map_view = d->view.cast<double>();
  const double far = 1 + partner.mahalanobis / (4 * scope.tolerance);
  const bool same_side = partner.map_view.dot(partner.view) >= kSameSide;
  const double weight = (same_side ? 1 : kOtherSideWeight) / (far * far);
  partner.J << Eigen::Matrix3d::Identity(), crossFromRight(p - about);
  partner.JW = weight * partner.J.transpose() * W;
  return true;
}

void Evidence::add(const QueryPoint& point, const Partner& partner) {
  PoseSystem& system = poses[point.pose];
  system.H += partner.JW * partner.J;
  system.b += partner.JW * partner.r;
  const double m = partner.mahalanobis;
  ++partners;
  cost += m / (1 + m / 4) - 4;
}

Evidence Registration::look(const std::vector<QueryPoint>& points, const Estimate& at,
                            const Scope& scope) const {
  Evidence evidence;
  evidence.poses.resize(poses_.size());
  forPartners(points, at, scope,
              [&](const QueryPoint& q, const Partner& partner) { evidence.add(q, partner); });
  return evidence;
}

double Registration::gravityInformation() const {
  return 1 / std::pow(options_.tilt_sigma_deg * kRadians, 2);
}

/// Of the given pose, in the plane and about z.
Vector6d Registration::givenInformation() const {
  Vector6d information = Vector6d::Zero();
  if (options_.start_sigma_m <= 0) return information;
  const double turn = options_.start_sigma_deg * kRadians;
  information.head<2>().setConstant(1 / (options_.start_sigma_m * options_.start_sigma_m));
  information(5) = 1 / (turn * turn);
  return information;
}

void Registration::addGivenPose(const Estimate& at, NormalEquations& n) const {
  const Vector6d information = givenInformation();
  const Eigen::Matrix3d turn = given_.linear() * at.T_map_query.linear().transpose();
  Vector6d away = Vector6d::Zero();
  away.head<2>() = (given_ * sensor_in_query_ - sensorOf(at)).head<2>();
  away(5) = std::atan2(turn(1, 0), turn(0, 0));
  n.H.diagonal().head<6>() += information;
  n.b.head<6>() += information.cwiseProduct(away);
  n.cost += away.dot(information.cwiseProduct(away));
}

/// The rotation since the start may turn about z freely, but hardly tilt.
void Registration::addPriors(const Estimate& at, NormalEquations& n) const {
  const Eigen::Vector3d upright =
      (at.T_map_query.linear() * up_in_query_)
          .cross(Eigen::Vector3d::UnitZ());  // rotation vector that would put it upright
  for (const int axis : {0, 1}) {
    n.H(3 + axis, 3 + axis) += gravityInformation();
    n.b(3 + axis) += gravityInformation() * upright(axis);
  }
  addGivenPose(at, n);
  if (chain_.knots() == 0) return;
  const Eigen::VectorXd pull = chain_.information() * at.drift;
  n.H.bottomRightCorner(chain_.size(), chain_.size()) += chain_.information();
  n.b.tail(chain_.size()) -= pull;
  n.cost += at.drift.dot(pull);
}

/// A pose errs like the last one and, in shares, like the two knots around it.
NormalEquations Registration::assemble(const Evidence& evidence, const Estimate& at) const {
  NormalEquations n;
  n.H = Eigen::MatrixXd::Zero(6 + chain_.size(), 6 + chain_.size());
  n.b = Eigen::VectorXd::Zero(6 + chain_.size());
  for (std::size_t pose = 0; pose < evidence.poses.size(); ++pose) {
    const Matrix6d H = trust_ * evidence.poses[pose].H;
    const Vector6d b = trust_ * evidence.poses[pose].b;
    n.H.topLeftCorner<6, 6>() += H;
    n.b.head<6>() += b;
    if (chain_.knots() == 0) continue;
    const DriftChain::Place& place = chain_.placeOf(pose);
    const std::array<double, 2> shares{1 - place.share, place.share};
    for (std::size_t i = place.knot == 0 ? 1 : 0; i < 2; ++i) {
      const auto row = static_cast<Eigen::Index>(6 * (place.knot + i));
      n.H.block<6, 6>(0, row) += shares[i] * H;
      n.H.block<6, 6>(row, 0) += shares[i] * H;
      n.b.segment<6>(row) += shares[i] * b;
      for (std::size_t j = place.knot == 0 ? 1 : 0; j < 2; ++j)
        n.H.block<6, 6>(row, static_cast<Eigen::Index>(6 * (place.knot + j))) +=
            shares[i] * shares[j] * H;
    }
  }
  n.cost = trust_ * evidence.cost;
  addPriors(at, n);
  return n;
}

Estimate Registration::moved(const Estimate& at, const Eigen::VectorXd& step) const {
  return {turnedAbout(sensorOf(at), step.head<6>()) * at.T_map_query,
          at.drift + step.tail(chain_.size())};
}

/// Gauss-Newton with a gate that narrows over the first 60 % of the iterations. Nearest
/// distributions change on the way, so that each step falls short: a part of the one before is
/// added, but for the last ones.
Registration::Descent Registration::descend(const std::vector<QueryPoint>& points,
                                            const Estimate& start, int iterations, bool measure) {
  constexpr double kStill = 1e-4, kMomentum = 0.5;
  constexpr int kWithoutMomentum = 4;
  Descent result;
  result.at = start;
  Eigen::VectorXd step = Eigen::VectorXd::Zero(6 + chain_.size());
  const std::size_t fewest = std::min(kFewestPartners, points.size() / 4 + 1);
  const int settled = static_cast<int>(std::ceil(0.6 * iterations));
  for (int i = 0; i < iterations; ++i) {
    const double progress = std::min(1.0, i / std::max(1.0, 0.6 * iterations));
    const double gate =
        options_.first_gate_m + progress * (options_.last_gate_m - options_.first_gate_m);
    result.last =
        look(points, result.at, {gate, std::pow(presumption_.first_tolerance, 1 - progress)});
    result.valid = false;
    if (result.last.partners < fewest) return result;
    const NormalEquations n = assemble(result.last, result.at);
    const Eigen::LDLT<Eigen::MatrixXd> factor(n.H);
    const Eigen::VectorXd d = factor.solve(n.b);
    if (!d.allFinite()) return result;
    step = d + (i + kWithoutMomentum < iterations ? kMomentum : 0) * step;
    result.at = moved(result.at, step);
    result.iterations = i + 1;
    result.valid = true;
    if (measure && (i == settled || i + kWithoutMomentum == iterations))
      trust_ = measuredTrust(points, result.at);
    if (progress == 1 && d.head<6>().norm() < kStill) break;
  }
  return result;
}

Registration::Start Registration::likelyStart(const std::vector<QueryPoint>& points) {
  constexpr std::size_t kPoints = 1000;
  constexpr int kIterations = 8, kToEachSide = 2;
  const std::vector<QueryPoint> few = evenlySpread(points, kPoints);
  const Estimate given = start();
  const NormalEquations here = assemble(look(few, given, {options_.first_gate_m, 1}), given);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(here.H.topLeftCorner<2, 2>());
  const Eigen::Vector2d along = axes.eigenvectors().col(0);
  std::vector<Arrival> arrivals;
  for (int k = -kToEachSide; k <= kToEachSide; ++k) {
    Estimate from = given;
    from.T_map_query.translation().head<2>() += options_.start_reach_m * k / kToEachSide * along;
    const Descent d = descend(few, from, kIterations, false);
    if (d.valid)
      arrivals.push_back({d.at, sensorOf(d.at), assemble(look(few, d.at, lastScope()), d.at).cost});
  }
  return arrivals.empty() ? Start{given} : meanOf(arrivals);
}

/// Points of one block err together: how far the pulls of blocks spread, against what points that
/// err on their own would show, tells what a point is worth.
double Registration::measuredTrust(const std::vector<QueryPoint>& points,
                                   const Estimate& at) const {
  std::map<Block, Vector6d> pulls;
  Matrix6d H = Matrix6d::Zero();
  forPartners(points, at, lastScope(), [&](const QueryPoint& q, const Partner& partner) {
    H += partner.JW * partner.J;
    pulls.try_emplace(blockOf(q), Vector6d::Zero()).first->second += partner.JW * partner.r;
  });
  Matrix6d spread = Matrix6d::Zero();
  for (const auto& [block, pull] : pulls) spread += pull * pull.transpose();
  const double excess = H.ldlt().solve(spread).trace() / 6;
  return 1 / (kBlocksAlike * std::clamp(excess, kLeastExcess, kMostExcess));
}

double Registration::scaleOf(const Estimate& at) const {
  const Eigen::Vector3d last = poses_.back().translation(), first = poses_.front().translation();
  if (last == first || chain_.knots() == 0) return 1;
  return (poseAt(at, 0) * first - poseAt(at, poses_.size() - 1) * last).norm() /
         (first - last).norm();
}

}  // namespace xview
