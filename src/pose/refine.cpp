// SPDX-License-Identifier: BSD-3-Clause
#include "xview/pose/refine.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "distribution_cells.h"

namespace xview {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Vector12d = Eigen::Matrix<double, 12, 1>;
using Matrix12d = Eigen::Matrix<double, 12, 12>;

constexpr double kRadians = M_PI / 180;
constexpr double kCorrelatedPoints = 20;  ///< so many points err like one
constexpr double kSameSide = -0.3;  ///< cosine between views that see the same side of a thing
constexpr double kOtherSideWeight = 0.1;
constexpr std::size_t kFewestPartners = 50;

struct QueryPoint {
  Eigen::Vector3d p;  ///< query frame
  std::uint32_t group = kNoGroup;
  Eigen::Vector3d view = Eigen::Vector3d::Zero();  ///< unit vector to who saw it; zero if unknown
  double age_m = 0;                                ///< way from where it was seen to the last pose
};

/// A pose, and what the odometry adds to it per metre of way: translation [m/m] and rotation vector
/// [rad/m], both in the map frame.
struct Estimate {
  Eigen::Isometry3d T_map_query;
  Vector6d drift = Vector6d::Zero();
};

/// Way from each pose to the last one.
std::vector<double> waysToLast(const std::vector<Eigen::Isometry3d>& poses) {
  std::vector<double> ways(poses.size(), 0);
  for (std::size_t i = poses.size() - 1; i-- > 0;)
    ways[i] = ways[i + 1] + (poses[i + 1].translation() - poses[i].translation()).norm();
  return ways;
}

QueryPoint queryPoint(const RefineQuery& query, const LabelSet& labels,
                      const std::vector<double>& ways, std::size_t i) {
  QueryPoint q;
  q.p = query.cloud.position(i);
  q.group = matchingGroup(labels, query.cloud.points[i].label);
  if (query.seen_from.size() != query.cloud.size()) return q;
  const std::size_t pose = std::min<std::size_t>(query.seen_from[i], query.poses.size() - 1);
  const Eigen::Vector3d view = query.poses[pose].translation() - q.p;
  if (view.norm() > 0) q.view = view.normalized();
  q.age_m = ways[pose];
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
  const std::vector<double> ways = waysToLast(query.poses);
  std::vector<QueryPoint> chosen;
  for (const std::size_t i : evenlySpread(usable, static_cast<std::size_t>(max_points)))
    chosen.push_back(queryPoint(query, labels, ways, i));
  return chosen;
}

/// L with L w = w x v, as the derivative of a point v under a rotation vector is.
Eigen::Matrix3d crossFromRight(const Eigen::Vector3d& v) {
  return (Eigen::Matrix3d() << 0, v.z(), -v.y(), -v.z(), 0, v.x(), v.y(), -v.x(), 0).finished();
}

/// One Gauss-Newton system about the last sensor: unknown are (translation, rotation vector), left
/// increment in the map frame, and the same per metre of way.
struct NormalEquations {
  Matrix12d H = Matrix12d::Zero();
  Vector12d b = Vector12d::Zero();
  std::vector<double> mahalanobis;  ///< squared, of each point with a partner
  double cost = 0;                  ///< sum over points; without a partner 0, exactly there -4
  double weight = 0, other_side = 0, unknown_side = 0;
  Vector12d side_pull = Vector12d::Zero();  ///< if all err by a metre towards where they were seen
                                            ///< from, in map and query
};

class Registration {
 public:
  Registration(const DistributionMap& map, const Eigen::Vector3d& sensor_in_query,
               const Eigen::Isometry3d& T_map_query, const RefineOptions& options)
      : cells_(DistributionCells::of(map)),
        sensor_in_query_(sensor_in_query),
        up_in_query_(T_map_query.linear().transpose().col(2)),
        given_(T_map_query),
        options_(options) {}

  Eigen::Vector3d sensorOf(const Estimate& at) const { return at.T_map_query * sensor_in_query_; }

  NormalEquations accumulate(const std::vector<QueryPoint>& points, const Estimate& at,
                             double gate_m) const;
  Matrix6d covarianceAt(const std::vector<QueryPoint>& points, const Estimate& at,
                        double sigma_m) const;

  struct Descent {
    bool valid = false;
    Estimate at;
    NormalEquations last;
    int iterations = 0;
  };
  Descent descend(const std::vector<QueryPoint>& points, const Estimate& start,
                  int iterations) const;
  Estimate bestStart(const std::vector<QueryPoint>& points, const Estimate& start) const;

 private:
  struct Pulls {
    NormalEquations all;
    Matrix12d spread = Matrix12d::Zero();  ///< sum over blocks of points
  };

  void add(const QueryPoint& q, const Estimate& at, float gate_m, NormalEquations& n) const;
  Pulls pullsAt(const std::vector<QueryPoint>& points, const Estimate& at) const;
  void addPriors(const Estimate& at, NormalEquations& n) const;
  void addGivenPose(const Estimate& at, NormalEquations& n) const;
  Vector6d givenInformation() const;
  double gravityInformation() const { return 1 / std::pow(options_.tilt_sigma_deg * kRadians, 2); }
  Vector6d driftInformation() const;
  Estimate moved(const Estimate& at, const Vector12d& step) const;

  const DistributionCells& cells_;
  const Eigen::Vector3d sensor_in_query_, up_in_query_;
  const Eigen::Isometry3d given_;
  const RefineOptions& options_;
};

void Registration::add(const QueryPoint& q, const Estimate& at, float gate_m,
                       NormalEquations& n) const {
  Eigen::Vector3d p = at.T_map_query * q.p;
  const Eigen::Vector3d lever = p - sensorOf(at);
  p += q.age_m * (at.drift.head<3>() + Eigen::Vector3d(at.drift.tail<3>()).cross(lever));
  const Distribution* d = cells_.nearest((p - cells_.origin()).cast<float>(), q.group, gate_m);
  if (!d) return;
  const Eigen::Vector3d r = cells_.origin() + d->mean.cast<double>() - p;
  const Eigen::Matrix3d W = d->information.cast<double>();
  const double m = r.dot(W * r);
  const Eigen::Vector3d view = at.T_map_query.linear() * q.view;
  const double cosine = d->view.cast<double>().dot(view);
  const double weight = (cosine < kSameSide ? kOtherSideWeight : 1) / ((1 + m / 4) * (1 + m / 4));
  Eigen::Matrix<double, 3, 6> J;
  J << Eigen::Matrix3d::Identity(), crossFromRight(lever);
  const Eigen::Matrix<double, 6, 3> JW = weight * J.transpose() * W;
  const Matrix6d H = JW * J;
  const Vector6d b = JW * r;
  n.H.topLeftCorner<6, 6>() += H;
  n.H.topRightCorner<6, 6>() += q.age_m * H;
  n.H.bottomRightCorner<6, 6>() += q.age_m * q.age_m * H;
  n.b.head<6>() += b;
  n.b.tail<6>() += q.age_m * b;
  n.mahalanobis.push_back(m);
  n.cost += m / (1 + m / 4) - 4;
  n.weight += weight;
  n.other_side += weight * (1 - cosine) / 2;
  if (d->view.isZero() || q.view.isZero()) {
    n.unknown_side += weight;
    return;
  }
  const Vector6d side = JW * (view - d->view.cast<double>());
  n.side_pull.head<6>() += side;
  n.side_pull.tail<6>() += q.age_m * side;
}

/// Of translation and rotation per metre; points that err together are counted as often here.
Vector6d Registration::driftInformation() const {
  constexpr double kNone = 1e-9;
  const bool drifts = options_.drift_share > 0;
  const double share = drifts ? options_.drift_share : kNone;
  const double turn = drifts ? std::max(kNone, options_.drift_deg_per_m * kRadians) : kNone;
  Vector6d information;
  information << Eigen::Vector3d::Constant(1 / (share * share)),
      Eigen::Vector3d::Constant(1 / (turn * turn));
  return kCorrelatedPoints * information;
}

/// Of the given pose, in the plane and about z; points that err together are counted as often here.
Vector6d Registration::givenInformation() const {
  Vector6d information = Vector6d::Zero();
  if (options_.start_sigma_m <= 0) return information;
  const double turn = options_.start_sigma_deg * kRadians;
  information.head<2>().setConstant(1 / (options_.start_sigma_m * options_.start_sigma_m));
  information(5) = 1 / (turn * turn);
  return kCorrelatedPoints * information;
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
  const Vector6d drift = driftInformation();
  n.H.diagonal().tail<6>() += drift;
  n.b.tail<6>() -= drift.cwiseProduct(at.drift);
}

NormalEquations Registration::accumulate(const std::vector<QueryPoint>& points, const Estimate& at,
                                         double gate_m) const {
  NormalEquations n;
  for (const QueryPoint& q : points) add(q, at, static_cast<float>(gate_m), n);
  n.H.bottomLeftCorner<6, 6>() = n.H.topRightCorner<6, 6>().transpose();
  addPriors(at, n);
  return n;
}

Estimate Registration::moved(const Estimate& at, const Vector12d& step) const {
  const Eigen::Vector3d about = sensorOf(at), turn = step.segment<3>(3);
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
  if (turn.norm() > 1e-15)
    motion.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  motion.translation() = about - motion.linear() * about + step.head<3>();
  return {motion * at.T_map_query, at.drift + step.tail<6>()};
}

/// Gauss-Newton with a gate that narrows over the first 60 % of the iterations. Nearest
/// distributions change on the way, so that each step falls short: a part of the one before is
/// added, but for the last ones.
Registration::Descent Registration::descend(const std::vector<QueryPoint>& points,
                                            const Estimate& start, int iterations) const {
  constexpr double kStill = 1e-4, kMomentum = 0.5;
  constexpr int kWithoutMomentum = 4;
  Descent result;
  result.at = start;
  Vector12d step = Vector12d::Zero();
  const std::size_t fewest = std::min(kFewestPartners, points.size() / 4 + 1);
  for (int i = 0; i < iterations; ++i) {
    const double progress = std::min(1.0, i / std::max(1.0, 0.6 * iterations));
    const double gate =
        options_.first_gate_m + progress * (options_.last_gate_m - options_.first_gate_m);
    result.last = accumulate(points, result.at, gate);
    result.valid = false;
    if (result.last.mahalanobis.size() < fewest) return result;
    const Vector12d d = result.last.H.ldlt().solve(result.last.b);
    if (!d.allFinite()) return result;
    step = d + (i + kWithoutMomentum < iterations ? kMomentum : 0) * step;
    result.at = moved(result.at, step);
    result.iterations = i + 1;
    result.valid = true;
    if (progress == 1 && d.head<6>().norm() < kStill) break;
  }
  return result;
}

/// Along a street little tells how far: places to both sides are tried with few points.
Estimate Registration::bestStart(const std::vector<QueryPoint>& points,
                                 const Estimate& start) const {
  constexpr std::size_t kPoints = 1000;
  constexpr int kIterations = 8, kToEachSide = 2;
  const std::vector<QueryPoint> few = evenlySpread(points, kPoints);
  const NormalEquations here = accumulate(few, start, options_.first_gate_m);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(here.H.topLeftCorner<2, 2>());
  const Eigen::Vector2d along = axes.eigenvectors().col(0);
  Estimate best = start;
  double best_cost = INFINITY;
  for (int k = -kToEachSide; k <= kToEachSide; ++k) {
    Estimate from = start;
    from.T_map_query.translation().head<2>() += options_.start_reach_m * k / kToEachSide * along;
    const Descent d = descend(few, from, kIterations);
    if (!d.valid) continue;
    const double cost = accumulate(few, d.at, options_.last_gate_m).cost;
    if (cost < best_cost) {
      best_cost = cost;
      best = d.at;
    }
  }
  return best;
}

/// How blocks of points pull, which would balance without noise (Liang & Zeger 1986): points of
/// one block err together.
Registration::Pulls Registration::pullsAt(const std::vector<QueryPoint>& points,
                                          const Estimate& at) const {
  constexpr double kBlock_m = 4;
  using Block = std::array<std::int64_t, 3>;
  std::map<Block, std::vector<const QueryPoint*>> blocks;
  for (const QueryPoint& q : points) {
    blocks[{static_cast<std::int64_t>(std::floor(q.p.x() / kBlock_m)),
            static_cast<std::int64_t>(std::floor(q.p.y() / kBlock_m)), q.group}]
        .push_back(&q);
  }
  const auto gate = static_cast<float>(options_.last_gate_m);
  Pulls pulls;
  for (const auto& [block, members] : blocks) {
    const Vector12d before = pulls.all.b;
    for (const QueryPoint* q : members) add(*q, at, gate, pulls.all);
    const Vector12d pull = pulls.all.b - before;
    pulls.spread += pull * pull.transpose();
  }
  pulls.all.H.bottomLeftCorner<6, 6>() = pulls.all.H.topRightCorner<6, 6>().transpose();
  addPriors(at, pulls.all);
  return pulls;
}

Matrix6d Registration::covarianceAt(const std::vector<QueryPoint>& points, const Estimate& at,
                                    double sigma_m) const {
  using E = RefinementErrors;
  Pulls pulls = pullsAt(points, at);
  for (const int axis : {3, 4}) pulls.spread(axis, axis) += gravityInformation();
  pulls.spread.diagonal().head<6>() += kCorrelatedPoints * givenInformation();
  pulls.spread.diagonal().tail<6>() += kCorrelatedPoints * driftInformation();
  const NormalEquations& all = pulls.all;
  const Matrix12d inverse = all.H.inverse();
  const Vector6d side = E::kSide_m * (inverse * all.side_pull).head<6>();
  Matrix6d covariance = E::kSpread * (inverse * pulls.spread * inverse).topLeftCorner<6, 6>();
  covariance += side * side.transpose();
  const auto square = [](double v) { return v * v; };
  const auto share = [&](double part) { return all.weight > 0 ? part / all.weight : 1; };
  const double alone =
      1 - static_cast<double>(all.mahalanobis.size()) / static_cast<double>(points.size());
  const double level =
      square(E::kFloor_m) + square(E::kSide_m * share(all.unknown_side)) +
      square(sigma_m) * (square(E::kCommon) + square(E::kOther * share(all.other_side)) +
                         square(E::kOther * alone));
  const double height = square(E::kFloorOfHeight_m) + square(E::kHeight * sigma_m * alone) +
                        square(E::kCommonHeight * sigma_m);
  const double turn = square(E::kFloorOfTurn_rad);
  const double tilt = turn + (height + square(E::kCommon * sigma_m)) / square(E::kLever_m);
  const double yaw = turn + level / square(E::kLever_m);
  covariance.diagonal() += (Vector6d() << level, level, height, tilt, tilt, yaw).finished();
  return 0.5 * (covariance + covariance.transpose());
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Length of the way in the map over that of the odometry.
double scaleOf(const Estimate& at, const std::vector<Eigen::Isometry3d>& poses) {
  const Eigen::Vector3d back = poses.front().translation() - poses.back().translation();
  if (back.norm() == 0) return 1;
  return 1 + at.drift.head<3>().dot(at.T_map_query.linear() * back.normalized());
}

}  // namespace

Refinement refine(const DistributionMap& map, const RefineQuery& query, const LabelSet& labels,
                  const Eigen::Isometry3d& T_map_query, const RefineOptions& options) {
  Refinement result;
  result.T_map_query = T_map_query;
  const std::vector<QueryPoint> points = choosePoints(query, labels, options.max_points);
  if (points.size() < kFewestPartners) return result;
  const Eigen::Vector3d sensor = query.poses.back().translation();
  const Registration registration(map, sensor, T_map_query, options);
  Estimate start{T_map_query};
  if (options.start_reach_m > 0) start = registration.bestStart(points, start);
  const Registration::Descent d = registration.descend(points, start, options.iterations);
  if (!d.valid) return result;
  result.T_map_query = d.at.T_map_query;
  result.iterations = d.iterations;
  result.overlap =
      static_cast<double>(d.last.mahalanobis.size()) / static_cast<double>(points.size());
  result.residual_m = options.roughness_m * std::sqrt(median(d.last.mahalanobis));
  result.scale = scaleOf(d.at, query.poses);
  result.covariance = registration.covarianceAt(points, d.at, query.sigma_m);
  const double shift = (result.T_map_query * sensor - T_map_query * sensor).norm();
  result.converged = shift <= options.max_shift_m;
  return result;
}

}  // namespace xview
