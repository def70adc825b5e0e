// SPDX-License-Identifier: BSD-3-Clause
#include "registration.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "base/median.h"
#include "xview/base/budget.h"

namespace xview::pose {
namespace {

constexpr double kRadians = M_PI / 180;
/// Error of the given pose in the plane and about the vertical, as a prior.
constexpr double kGivenSigma_m = 1, kGivenSigma_rad = 1.5 * kRadians;
/// Error of the direction of the odometry where a window shows drift, per metre.
constexpr double kDriftTurn_deg = 0.045;
/// Factors on the weight of a point of ground and of a post: ground is most of the points and holds
/// little information about the position along a street, posts are few and localize sharply.
constexpr double kGroundWeight = 1.0 / 3, kPostWeight = 3;
constexpr double kBlock_m = 4;
constexpr double kCorrelatedPoints =
    20;                             ///< this number of points errs like one, before it is measured
constexpr double kSameSide = -0.3;  ///< cosine between views of the same side of an object
constexpr double kOtherSideWeight = 0.1;
/// Factor on the spread of the gradients of blocks over their scatter: the points of a block have
/// errors in common.
constexpr double kBlocksAlike = 40;
constexpr double kLeastExcess = 1e-3, kMostExcess = 1e3;

QueryPoint queryPoint(const RefineQuery& query, const LabelSet& labels, std::size_t i) {
  QueryPoint q;
  q.pose = query.poses.size() - 1;
  q.p = query.cloud.position(i);
  q.group = matchingGroup(labels, query.cloud.points[i].label);
  const std::uint32_t seen_from = query.cloud.points[i].view;
  if (seen_from == kNoView) return q;
  q.pose = std::min<std::size_t>(seen_from, query.poses.size() - 1);
  const Eigen::Vector3d view = query.poses[q.pose].translation() - q.p;
  if (view.norm() > 0) q.view = view.normalized();
  return q;
}

double weightOf(std::uint32_t group) {
  const Kind kind = kindOfGroup(group);
  return isGround(kind) ? kGroundWeight : isPoleLike(kind) ? kPostWeight : 1;
}

/// From each pose to the last one.
std::vector<double> waysToLast(const std::vector<Eigen::Isometry3d>& poses) {
  std::vector<double> ways(poses.size(), 0);
  for (std::size_t i = poses.size() - 1; i-- > 0;)
    ways[i] = ways[i + 1] + (poses[i + 1].translation() - poses[i].translation()).norm();
  return ways;
}

Eigen::Isometry3d turnedAbout(const Eigen::Vector3d& about, const Vector6d& by) {
  const Eigen::Vector3d turn = by.tail<3>();
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  if (turn.norm() > 1e-15)
    motion.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  motion.translation() = about - motion.linear() * about + by.head<3>();
  return motion;
}

/// Where a start leads to.
struct Outcome {
  Estimate at;
  Eigen::Vector3d sensor;
  double cost;  ///< -2 log likelihood
};

/// By likelihood, in the plane.
Registration::Start meanOf(const std::vector<Outcome>& outcomes) {
  const auto by_cost = [](const Outcome& a, const Outcome& b) { return a.cost < b.cost; };
  const Outcome& best = *std::min_element(outcomes.begin(), outcomes.end(), by_cost);
  double weight = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (const Outcome& o : outcomes) {
    const double likelihood = std::exp(0.5 * (best.cost - o.cost));
    Eigen::Vector3d away = o.sensor - best.sensor;
    away.z() = 0;
    weight += likelihood;
    sum += likelihood * away;
    squares += likelihood * away * away.transpose();
  }
  const Eigen::Vector3d mean = sum / weight;
  Registration::Start start{best.at, 0, squares / weight - mean * mean.transpose()};
  start.at.T_map_query.pretranslate(mean);
  return start;
}

}  // namespace

std::vector<QueryPoint> choosePoints(const RefineQuery& query, const LabelSet& labels,
                                     int max_points) {
  std::map<std::uint32_t, std::vector<std::size_t>> groups;
  for (std::size_t i = 0; i < query.cloud.size(); ++i) {
    const Point& point = query.cloud.points[i];
    const std::uint32_t group = matchingGroup(labels, point.label);
    if (group != kNoGroup && point.getVector3fMap().allFinite()) groups[group].push_back(i);
  }
  double weight = 0;
  for (const auto& [group, points] : groups)
    weight += weightOf(group) * static_cast<double>(points.size());
  std::vector<std::size_t> indices;
  for (const auto& [group, points] : groups) {
    const double share = weightOf(group) * static_cast<double>(points.size()) / weight;
    const auto some = evenlySpread(points, static_cast<std::size_t>(std::ceil(max_points * share)));
    indices.insert(indices.end(), some.begin(), some.end());
  }
  std::sort(indices.begin(), indices.end());
  std::vector<QueryPoint> chosen;
  for (const std::size_t i : indices) chosen.push_back(queryPoint(query, labels, i));
  return chosen;
}

Block blockOf(const QueryPoint& q) {
  return {static_cast<std::int64_t>(std::floor(q.p.x() / kBlock_m)),
          static_cast<std::int64_t>(std::floor(q.p.y() / kBlock_m)), q.group};
}

void Evidence::add(const QueryPoint& point, const Partner& partner) {
  System& system = poses[point.pose];
  system.H += partner.JW * partner.J;
  system.b += partner.JW * partner.r;
  const double m = partner.mahalanobis;
  ++partners;
  cost += m / (1 + m / 4) - 4;
}

Registration::Registration(const DistributionMap& map, const RefineQuery& query,
                           const Eigen::Isometry3d& T_map_query,
                           const std::vector<QueryPoint>& points, const RefineOptions& options,
                           const DriftPrior& prior)
    : map_(map),
      poses_(query.poses),
      sensor_in_query_(query.poses.back().translation()),
      up_in_query_(T_map_query.linear().transpose().col(2)),
      given_(T_map_query),
      options_(options),
      first_tolerance_(prior.first_tolerance),
      drift_(driftOf(points, prior.scale)),
      point_weight_(1 / kCorrelatedPoints) {}

DriftChain Registration::driftOf(const std::vector<QueryPoint>& points, double scale) const {
  const std::vector<double> ways = waysToLast(poses_);
  double reach_m = 0;
  for (const QueryPoint& q : points) reach_m = std::max(reach_m, ways[q.pose]);
  std::vector<Eigen::Vector3d> sensors;
  for (const Eigen::Isometry3d& T : poses_)
    sensors.push_back(given_.linear() * (T.translation() - sensor_in_query_));
  return DriftChain(ways, sensors, reach_m,
                    {scale * options_.model.drift_share, scale * kDriftTurn_deg * kRadians});
}

/// Takes what was seen from a pose to the map.
Eigen::Isometry3d Registration::poseAt(const Estimate& at, std::size_t pose) const {
  if (drift_.size() == 0) return at.T_map_query;
  return turnedAbout(sensorOf(at), drift_.errorOf(pose, at.drift)) * at.T_map_query;
}

bool Registration::findPartner(const QueryPoint& q, const Eigen::Isometry3d& T,
                               const Eigen::Vector3d& about, const Scope& scope,
                               DistributionMap::Nearest& last, Partner& partner) const {
  const Eigen::Vector3d p = T * q.p;
  const Distribution* d = map_.nearest((p - map_.origin()).cast<float>(), q.group,
                                       static_cast<float>(scope.gate_m), last);
  if (!d) return false;
  partner.r = map_.origin() + d->mean.cast<double>() - p;
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

Evidence Registration::evidenceAt(const Estimate& at, const std::vector<QueryPoint>& points,
                                  const Scope& scope, LastPartners* last) const {
  Evidence evidence(poses_.size());
  forPartners(
      points, at, scope,
      [&](const QueryPoint& q, const Partner& partner) { evidence.add(q, partner); }, last);
  return evidence;
}

/// A pose errs like the last one and, in shares, like the two knots around it.
NormalEquations Registration::assemble(const Evidence& evidence, const Estimate& at) const {
  NormalEquations n;
  n.H = Eigen::MatrixXd::Zero(6 + drift_.size(), 6 + drift_.size());
  n.b = Eigen::VectorXd::Zero(6 + drift_.size());
  for (std::size_t pose = 0; pose < evidence.poses.size(); ++pose) {
    const Matrix6d H = point_weight_ * evidence.poses[pose].H;
    const Vector6d b = point_weight_ * evidence.poses[pose].b;
    n.H.topLeftCorner<6, 6>() += H;
    n.b.head<6>() += b;
    for (const auto& [row, share] : drift_.sharesOf(pose)) {
      n.H.block<6, 6>(0, 6 + row) += share * H;
      n.H.block<6, 6>(6 + row, 0) += share * H;
      n.b.segment<6>(6 + row) += share * b;
      for (const auto& [column, other] : drift_.sharesOf(pose))
        n.H.block<6, 6>(6 + row, 6 + column) += share * other * H;
    }
  }
  n.cost = point_weight_ * evidence.cost;
  addPriors(at, n);
  return n;
}

void Registration::addPriors(const Estimate& at, NormalEquations& n) const {
  // The rotation since the start may turn about z, but hardly tilt. This rotation vector would put
  // it upright.
  const double gravity = 1 / std::pow(options_.tilt_sigma_deg * kRadians, 2);
  const Eigen::Vector3d upright =
      (at.T_map_query.linear() * up_in_query_).cross(Eigen::Vector3d::UnitZ());
  for (const int axis : {0, 1}) {
    n.H(3 + axis, 3 + axis) += gravity;
    n.b(3 + axis) += gravity * upright(axis);
  }
  // The given pose, in the plane and about z.
  Vector6d information = Vector6d::Zero(), away = Vector6d::Zero();
  information.head<2>().setConstant(1 / (kGivenSigma_m * kGivenSigma_m));
  information(5) = 1 / (kGivenSigma_rad * kGivenSigma_rad);
  const Eigen::Matrix3d turn = given_.linear() * at.T_map_query.linear().transpose();
  away.head<2>() = (given_ * sensor_in_query_ - sensorOf(at)).head<2>();
  away(5) = std::atan2(turn(1, 0), turn(0, 0));
  n.H.diagonal().head<6>() += information;
  n.b.head<6>() += information.cwiseProduct(away);
  n.cost += away.dot(information.cwiseProduct(away));
  // The drift is zero.
  if (drift_.size() == 0) return;
  const Eigen::VectorXd pull = drift_.information() * at.drift;
  n.H.bottomRightCorner(drift_.size(), drift_.size()) += drift_.information();
  n.b.tail(drift_.size()) -= pull;
  n.cost += at.drift.dot(pull);
}

Estimate Registration::moved(const Estimate& at, const Eigen::VectorXd& step) const {
  return {turnedAbout(sensorOf(at), step.head<6>()) * at.T_map_query,
          at.drift + step.tail(drift_.size())};
}

/// Gauss-Newton with a gate that narrows over the first 60 % of the iterations. Nearest
/// distributions change on the way, so that each step falls short: a part of the one before is
/// added, but for the last ones.
Registration::Descent Registration::descend(const std::vector<QueryPoint>& points,
                                            const Estimate& start, int iterations, bool weigh) {
  constexpr double kStill = 1e-4, kMomentum = 0.5;
  constexpr int kWithoutMomentum = 4;
  const double first_gate_m = options_.model.first_gate_m, last_gate_m = lastScope().gate_m;
  Descent result;
  result.at = start;
  LastPartners last;
  Eigen::VectorXd step = Eigen::VectorXd::Zero(6 + drift_.size());
  const std::size_t fewest = std::min(kFewestPartners, points.size() / 4 + 1);
  const int settled = static_cast<int>(std::ceil(0.6 * iterations));
  for (int i = 0; i < iterations; ++i) {
    askBudget("the registration");
    const double progress = std::min(1.0, i / std::max(1.0, 0.6 * iterations));
    const Evidence evidence = evidenceAt(result.at, points,
                                         {first_gate_m + progress * (last_gate_m - first_gate_m),
                                          std::pow(first_tolerance_, 1 - progress)},
                                         &last);
    result.partners = evidence.partners;
    result.valid = false;
    if (result.partners < fewest) return result;
    const NormalEquations n = assemble(evidence, result.at);
    const Eigen::LDLT<Eigen::MatrixXd> factor(n.H);
    const Eigen::VectorXd d = factor.solve(n.b);
    if (!d.allFinite()) return result;
    step = d + (i + kWithoutMomentum < iterations ? kMomentum : 0) * step;
    result.at = moved(result.at, step);
    result.valid = true;
    if (weigh && (i == settled || i + kWithoutMomentum == iterations))
      point_weight_ = measuredWeight(points, result.at);
    if (progress == 1 && d.head<6>().norm() < kStill) break;
  }
  return result;
}

Registration::Start Registration::multiStart(const std::vector<QueryPoint>& points) {
  constexpr std::size_t kPoints = 1000;
  constexpr int kIterations = 8, kToEachSide = 2;
  Estimate given = start();
  if (!(options_.model.start_reach_m > 0)) return {given};
  const double rise_m = riseToFit(points);
  given.T_map_query.translation().z() += rise_m;
  const std::vector<QueryPoint> few = evenlySpread(points, kPoints);
  const Scope first{options_.model.first_gate_m, 1};
  const NormalEquations here = assemble(evidenceAt(given, few, first), given);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(here.H.topLeftCorner<2, 2>());
  const Eigen::Vector2d along = axes.eigenvectors().col(0);
  std::vector<Outcome> outcomes;
  for (int k = -kToEachSide; k <= kToEachSide; ++k) {
    Estimate from = given;
    from.T_map_query.translation().head<2>() +=
        options_.model.start_reach_m * k / kToEachSide * along;
    const Descent d = descend(few, from, kIterations, false);
    if (!d.valid) continue;
    outcomes.push_back(
        {d.at, sensorOf(d.at), assemble(evidenceAt(d.at, few, lastScope()), d.at).cost});
  }
  Start best = outcomes.empty() ? Start{given} : meanOf(outcomes);
  best.rise_m = rise_m;
  return best;
}

/// Floors and tables lie on their like or not wherever the walls are.
double Registration::riseToFit(const std::vector<QueryPoint>& points) const {
  constexpr std::size_t kPoints = 400;
  const std::vector<QueryPoint> few = evenlySpread(points, kPoints);
  const double weight =
      point_weight_ * static_cast<double>(points.size()) / static_cast<double>(few.size());
  const double rise_m = bestRise(few, weight);
  // Walls may fit best where both were measured densely. Their ground is on another level then.
  constexpr std::size_t kFewestOnGround = 5;  // and a quarter of it
  std::vector<QueryPoint> ground;
  for (const QueryPoint& q : few) {
    if (isGround(kindOfGroup(q.group))) ground.push_back(q);
  }
  const auto onGround = [&](double at_m) {
    std::size_t count = 0;
    forPartners(ground, risen(at_m), lastScope(), [&](const auto&, const auto&) { ++count; });
    return count;
  };
  const std::size_t there = onGround(rise_m);
  if (ground.size() < kFewestOnGround || 2 * there >= ground.size()) return rise_m;
  const double by_ground_m = bestRise(ground, weight);
  const std::size_t most = onGround(by_ground_m);
  const std::size_t fewest = std::max(kFewestOnGround, ground.size() / 4);
  return most >= fewest && 2 * there < most ? by_ground_m : rise_m;
}

/// Of some points, each of which counts `weight`.
double Registration::bestRise(const std::vector<QueryPoint>& points, double weight) const {
  constexpr double kStep_m = 0.2, kSigma_m = 1;
  constexpr int kSteps = 15;
  double best_m = 0, least = INFINITY;
  for (int k = -kSteps; k <= kSteps; ++k) {
    const double rise_m = k * kStep_m;
    const double cost = weight * evidenceAt(risen(rise_m), points, lastScope()).cost +
                        std::pow(rise_m / kSigma_m, 2);
    if (cost >= least) continue;
    least = cost;
    best_m = rise_m;
  }
  return best_m;
}

Estimate Registration::risen(double rise_m) const {
  Estimate at = start();
  at.T_map_query.translation().z() += rise_m;
  return at;
}

/// Points of one block err together: how far the pulls of blocks spread, against what points that
/// err on their own would show, tells what a point is worth.
double Registration::measuredWeight(const std::vector<QueryPoint>& points,
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

}  // namespace xview::pose
