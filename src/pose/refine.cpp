// SPDX-License-Identifier: BSD-3-Clause
#include "xview/pose/refine.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "distribution_cells.h"
#include "drift_chain.h"
#include "xview/types/median.h"

namespace xview {
namespace {

constexpr double kRadians = M_PI / 180;
constexpr double kCorrelatedPoints = 20;  ///< so many points err like one, before it is measured
constexpr double kSameSide = -0.3;  ///< cosine between views that see the same side of a thing
constexpr double kOtherSideWeight = 0.1;
constexpr std::size_t kFewestPartners = 50;
constexpr double kSteady = 0.4;     ///< of the drift of the options, where a window shows none
constexpr double kTolerance = 30;   ///< where it may: points may be off by some 2 m
constexpr double kShownDrift = 50;  ///< by so much points must fit better with drift
/// Pulls of blocks spread by so much more than their scatter shows: their points have more in
/// common.
constexpr double kBlocksAlike = 40;
constexpr double kLeastExcess = 1e-3, kMostExcess = 1e3;

struct QueryPoint {
  Eigen::Vector3d p;  ///< query frame
  std::uint32_t group = kNoGroup;
  Eigen::Vector3d view = Eigen::Vector3d::Zero();  ///< unit vector to who saw it; zero if unknown
  std::size_t pose = 0;                            ///< that it was seen from
};

/// A pose, and how far the odometry is off at the knots of the chain.
struct Estimate {
  Eigen::Isometry3d T_map_query;
  Eigen::VectorXd drift;
};

/// Way from each pose to the last one.
std::vector<double> waysToLast(const std::vector<Eigen::Isometry3d>& poses) {
  std::vector<double> ways(poses.size(), 0);
  for (std::size_t i = poses.size() - 1; i-- > 0;)
    ways[i] = ways[i + 1] + (poses[i + 1].translation() - poses[i].translation()).norm();
  return ways;
}

QueryPoint queryPoint(const RefineQuery& query, const LabelSet& labels, std::size_t i) {
  QueryPoint q;
  q.pose = query.poses.size() - 1;
  q.p = query.cloud.position(i);
  q.group = matchingGroup(labels, query.cloud.points[i].label);
  if (query.seen_from.size() != query.cloud.size()) return q;
  q.pose = std::min<std::size_t>(query.seen_from[i], query.poses.size() - 1);
  const Eigen::Vector3d view = query.poses[q.pose].translation() - q.p;
  if (view.norm() > 0) q.view = view.normalized();
  return q;
}

template <class T>
std::vector<T> evenlySpread(const std::vector<T>& all, std::size_t count) {
  count = std::min(all.size(), count);
  std::vector<T> chosen;
  for (std::size_t k = 0; k < count; ++k) chosen.push_back(all[k * all.size() / count]);
  return chosen;
}

std::vector<QueryPoint> choosePoints(const RefineQuery& query, const LabelSet& labels,
                                     int max_points) {
  std::vector<std::size_t> usable;
  for (std::size_t i = 0; i < query.cloud.size(); ++i) {
    const pcl::PointXYZL& point = query.cloud.points[i];
    if (matchingGroup(labels, point.label) != kNoGroup && point.getVector3fMap().allFinite())
      usable.push_back(i);
  }
  std::vector<QueryPoint> chosen;
  for (const std::size_t i : evenlySpread(usable, static_cast<std::size_t>(max_points)))
    chosen.push_back(queryPoint(query, labels, i));
  return chosen;
}

/// One Gauss-Newton system about the last sensor: unknown are (translation, rotation vector), left
/// increment in the map frame, and the same for each knot of the drift.
struct NormalEquations {
  Eigen::MatrixXd H;
  Eigen::VectorXd b;
  double cost = 0;  ///< of points and priors
};

/// What the points of one pose say, one rigid body.
struct PoseSystem {
  Matrix6d H = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();
};

/// How far off a point may be to have a say.
struct Scope {
  double gate_m;
  double tolerance;  ///< of a squared Mahalanobis distance; 1 at the end
};

/// What the points say.
struct Evidence {
  std::vector<PoseSystem> poses;
  std::vector<double> mahalanobis;  ///< squared, of each point with a partner
  double cost = 0;                  ///< sum over points; without a partner 0, exactly there -4
};

/// How much of the drift of the options a window is presumed to have, and how far off its points
/// may be at first (see Scope).
struct Presumption {
  double drift;
  double first_tolerance;
};

class Registration {
 public:
  Registration(const DistributionMap& map, const RefineQuery& query,
               const Eigen::Isometry3d& T_map_query, const std::vector<QueryPoint>& points,
               const RefineOptions& options, const Presumption& presumption)
      : cells_(DistributionCells::of(map)),
        poses_(query.poses),
        sensor_in_query_(query.poses.back().translation()),
        up_in_query_(T_map_query.linear().transpose().col(2)),
        given_(T_map_query),
        options_(options),
        presumption_(presumption),
        chain_(chainOf(points)) {}

  bool canDrift() const { return chain_.knots() > 0; }
  Estimate start() const { return {given_, Eigen::VectorXd::Zero(chain_.size())}; }
  Eigen::Vector3d sensorOf(const Estimate& at) const { return at.T_map_query * sensor_in_query_; }

  Matrix6d covarianceAt(const std::vector<QueryPoint>& points, const Estimate& at,
                        const Eigen::Vector3d& other_sensor, double sigma_m) const;

  struct Descent {
    bool valid = false;
    Estimate at;
    Evidence last;
    int iterations = 0;
  };
  Descent descend(const std::vector<QueryPoint>& points, const Estimate& start, int iterations,
                  bool measure);
  Estimate bestStart(const std::vector<QueryPoint>& points, const Estimate& start);
  double scaleOf(const Estimate& at) const;
  double costOf(const std::vector<QueryPoint>& points, const Estimate& at) const {
    return look(points, at, {options_.last_gate_m, 1}).cost;
  }

 private:
  DriftChain chainOf(const std::vector<QueryPoint>& points) const;
  Eigen::Isometry3d poseAt(const Estimate& at, std::size_t pose) const;
  Evidence look(const std::vector<QueryPoint>& points, const Estimate& at,
                const Scope& scope) const;
  void add(const QueryPoint& q, const Eigen::Isometry3d& T, const Eigen::Vector3d& about,
           const Scope& scope, PoseSystem& system, Evidence& all) const;
  NormalEquations assemble(const Evidence& evidence, const Estimate& at) const;
  void addPriors(const Estimate& at, NormalEquations& n) const;
  void addGivenPose(const Estimate& at, NormalEquations& n) const;
  double measuredTrust(const std::vector<QueryPoint>& points, const Estimate& at) const;
  Vector6d givenInformation() const;
  double gravityInformation() const { return 1 / std::pow(options_.tilt_sigma_deg * kRadians, 2); }
  Estimate moved(const Estimate& at, const Eigen::VectorXd& step) const;

  const DistributionCells& cells_;
  const std::vector<Eigen::Isometry3d>& poses_;
  const Eigen::Vector3d sensor_in_query_, up_in_query_;
  const Eigen::Isometry3d given_;
  const RefineOptions& options_;
  const Presumption presumption_;
  DriftChain chain_;
  double trust_ =
      1 / kCorrelatedPoints;  ///< information of a point, over that of an independent one
};

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

Eigen::Isometry3d turnedAbout(const Eigen::Vector3d& about, const Vector6d& by) {
  const Eigen::Vector3d turn = by.tail<3>();
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  if (turn.norm() > 1e-15)
    motion.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  motion.translation() = about - motion.linear() * about + by.head<3>();
  return motion;
}

/// Takes what was seen from a pose to the map.
Eigen::Isometry3d Registration::poseAt(const Estimate& at, std::size_t pose) const {
  if (chain_.knots() == 0) return at.T_map_query;
  return turnedAbout(sensorOf(at), chain_.at(chain_.placeOf(pose), at.drift)) * at.T_map_query;
}

void Registration::add(const QueryPoint& q, const Eigen::Isometry3d& T,
                       const Eigen::Vector3d& about, const Scope& scope, PoseSystem& system,
                       Evidence& all) const {
  const Eigen::Vector3d p = T * q.p;
  const Distribution* d = cells_.nearest((p - cells_.origin()).cast<float>(), q.group,
                                         static_cast<float>(scope.gate_m));
  if (!d) return;
  const Eigen::Vector3d r = cells_.origin() + d->mean.cast<double>() - p;
  const Eigen::Matrix3d W = d->information.cast<double>();
  const double m = r.dot(W * r);
  const Eigen::Vector3d view = T.linear() * q.view;
  const double cosine = d->view.cast<double>().dot(view);
  const double far = 1 + m / (4 * scope.tolerance);
  const double weight = (cosine < kSameSide ? kOtherSideWeight : 1) / (far * far);
  Eigen::Matrix<double, 3, 6> J;
  J << Eigen::Matrix3d::Identity(), crossFromRight(p - about);
  const Eigen::Matrix<double, 6, 3> JW = weight * J.transpose() * W;
  system.H += JW * J;
  system.b += JW * r;
  all.mahalanobis.push_back(m);
  all.cost += m / (1 + m / 4) - 4;
}

Evidence Registration::look(const std::vector<QueryPoint>& points, const Estimate& at,
                            const Scope& scope) const {
  Evidence evidence;
  evidence.poses.resize(poses_.size());
  const Eigen::Vector3d about = sensorOf(at);
  std::size_t pose = poses_.size();
  Eigen::Isometry3d T = at.T_map_query;
  for (const QueryPoint& q : points) {
    if (q.pose != pose) T = poseAt(at, pose = q.pose);
    add(q, T, about, scope, evidence.poses[pose], evidence);
  }
  return evidence;
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
    if (result.last.mahalanobis.size() < fewest) return result;
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

/// Along a street little tells how far: places to both sides are tried with few points.
Estimate Registration::bestStart(const std::vector<QueryPoint>& points, const Estimate& start) {
  constexpr std::size_t kPoints = 1000;
  constexpr int kIterations = 8, kToEachSide = 2;
  const std::vector<QueryPoint> few = evenlySpread(points, kPoints);
  const NormalEquations here = assemble(look(few, start, {options_.first_gate_m, 1}), start);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(here.H.topLeftCorner<2, 2>());
  const Eigen::Vector2d along = axes.eigenvectors().col(0);
  Estimate best = start;
  double best_cost = INFINITY;
  for (int k = -kToEachSide; k <= kToEachSide; ++k) {
    Estimate from = start;
    from.T_map_query.translation().head<2>() += options_.start_reach_m * k / kToEachSide * along;
    const Descent d = descend(few, from, kIterations, false);
    if (!d.valid) continue;
    const double cost = assemble(look(few, d.at, {options_.last_gate_m, 1}), d.at).cost;
    if (cost < best_cost) {
      best_cost = cost;
      best = d.at;
    }
  }
  return best;
}

/// Points of one block err together: how far the pulls of blocks spread, against what points that
/// err on their own would show, tells what a point is worth.
double Registration::measuredTrust(const std::vector<QueryPoint>& points,
                                   const Estimate& at) const {
  constexpr double kBlock_m = 4;
  using Block = std::array<std::int64_t, 3>;
  std::map<Block, PoseSystem> blocks;
  Evidence all;
  std::size_t pose = poses_.size();
  Eigen::Isometry3d T = at.T_map_query;
  for (const QueryPoint& q : points) {
    if (q.pose != pose) T = poseAt(at, pose = q.pose);
    add(q, T, sensorOf(at), {options_.last_gate_m, 1},
        blocks[{static_cast<std::int64_t>(std::floor(q.p.x() / kBlock_m)),
                static_cast<std::int64_t>(std::floor(q.p.y() / kBlock_m)), q.group}],
        all);
  }
  Matrix6d H = Matrix6d::Zero(), spread = Matrix6d::Zero();
  for (const auto& [block, pull] : blocks) {
    H += pull.H;
    spread += pull.b * pull.b.transpose();
  }
  const double excess = H.ldlt().solve(spread).trace() / 6;
  return 1 / (kBlocksAlike * std::clamp(excess, kLeastExcess, kMostExcess));
}

/// What points and presumptions leave open, more of it the less well the points are known, and what
/// the answer would have been under the other presumption.
Matrix6d Registration::covarianceAt(const std::vector<QueryPoint>& points, const Estimate& at,
                                    const Eigen::Vector3d& other_sensor, double sigma_m) const {
  using E = RefinementErrors;
  const NormalEquations n = assemble(look(points, at, {options_.last_gate_m, 1}), at);
  const Eigen::LDLT<Eigen::MatrixXd> factor(n.H);
  const Matrix6d open = factor.solve(Eigen::MatrixXd::Identity(n.H.rows(), 6)).topRows<6>();
  Vector6d scale;
  scale << E::kPlane, E::kPlane, E::kHeight, E::kTilt, E::kTilt, E::kYaw;
  scale *= std::hypot(1, sigma_m / E::kKnownWell_m);
  Matrix6d covariance = scale.asDiagonal() * open * scale.asDiagonal();
  const Eigen::Vector3d apart = E::kOtherAnswer * (other_sensor - sensorOf(at));
  covariance.topLeftCorner<3, 3>() += apart * apart.transpose();
  const double level = std::hypot(E::kFloor_m, E::kCommon * sigma_m);
  covariance.diagonal() +=
      (Vector6d() << level, level, E::kFloor_m, E::kFloor_rad, E::kFloor_rad, E::kFloor_rad)
          .finished()
          .cwiseAbs2();
  return 0.5 * (covariance + covariance.transpose());
}

/// Length of the way in the map over that of the odometry.
double Registration::scaleOf(const Estimate& at) const {
  const Eigen::Vector3d last = poses_.back().translation(), first = poses_.front().translation();
  if (last == first || chain_.knots() == 0) return 1;
  return (poseAt(at, 0) * first - poseAt(at, poses_.size() - 1) * last).norm() /
         (first - last).norm();
}

/// A window under one presumption.
struct Fit {
  Registration registration;
  Estimate start;
  Registration::Descent descent;
  double cost = INFINITY;  ///< of the points, without what was presumed
};

Fit startedFit(Registration registration, const std::vector<QueryPoint>& points, bool search) {
  Fit fit{std::move(registration), {}, {}};
  fit.start = fit.registration.start();
  if (search) fit.start = fit.registration.bestStart(points, fit.start);
  return fit;
}

void descend(const std::vector<QueryPoint>& points, int iterations, Fit& fit) {
  fit.descent = fit.registration.descend(points, fit.start, iterations, true);
  if (fit.descent.valid) fit.cost = fit.registration.costOf(points, fit.descent.at);
}

}  // namespace

Refinement refine(const DistributionMap& map, const RefineQuery& query, const LabelSet& labels,
                  const Eigen::Isometry3d& T_map_query, const RefineOptions& options) {
  Refinement result;
  result.T_map_query = T_map_query;
  const std::vector<QueryPoint> points = choosePoints(query, labels, options.max_points);
  if (points.size() < kFewestPartners) return result;
  const Eigen::Vector3d sensor = query.poses.back().translation();
  const Registration few{map, query, T_map_query, points, options, {kSteady, 1}};
  Fit steady = startedFit(few, points, options.start_reach_m > 0);
  descend(points, 1 + 2 * options.iterations / 3, steady);
  const Registration more{map, query, T_map_query, points, options, {1, kTolerance}};
  Fit drifting = startedFit(more, points, false);
  drifting.start.T_map_query = steady.start.T_map_query;
  if (more.canDrift()) descend(points, options.iterations, drifting);
  const bool drifts = drifting.descent.valid &&
                      (!steady.descent.valid || steady.cost - drifting.cost > kShownDrift);
  const Fit &best = drifts ? drifting : steady, &other = drifts ? steady : drifting;
  const Registration::Descent& d = best.descent;
  if (!d.valid) return result;
  result.T_map_query = d.at.T_map_query;
  result.iterations = d.iterations;
  result.overlap =
      static_cast<double>(d.last.mahalanobis.size()) / static_cast<double>(points.size());
  result.residual_m = options.roughness_m * std::sqrt(medianOf(d.last.mahalanobis));
  result.scale = best.registration.scaleOf(d.at);
  const Eigen::Vector3d elsewhere =
      other.registration.sensorOf(other.descent.valid ? other.descent.at : d.at);
  result.covariance = best.registration.covarianceAt(points, d.at, elsewhere, query.sigma_m);
  const double shift = (result.T_map_query * sensor - T_map_query * sensor).norm();
  result.converged = shift <= options.max_shift_m;
  return result;
}

}  // namespace xview
