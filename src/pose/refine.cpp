// SPDX-License-Identifier: BSD-3-Clause
#include "xview/pose/refine.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace xview {
namespace {

constexpr std::uint32_t kFirstOtherGroup = static_cast<std::uint32_t>(Kind::none) + 1;
constexpr std::uint32_t kNoGroup = 0xFFFFFFFF;
constexpr double kCorrelatedPoints = 20;  ///< so many points err like one
constexpr double kFloor_m = 0.05, kFloor_rad = 0.05 * M_PI / 180;
constexpr int kFewestPoints = 4;  ///< of a distribution

/// Points match within a group: a kind of thing, or one class if its kind is not known. Lane
/// markings lie on the road.
std::uint32_t groupOf(const LabelSet& labels, std::uint32_t label) {
  const Role role = labels.role(label);
  if (role == Role::ignored || role == Role::dynamic) return kNoGroup;
  const Kind kind = labels.kind(label);
  if (kind == Kind::lane_marking) return static_cast<std::uint32_t>(Kind::road);
  if (kind == Kind::other_object || kind == Kind::other_surface) return kFirstOtherGroup + label;
  return static_cast<std::uint32_t>(kind);
}

struct CellKey {
  std::int32_t x, y, z;
  std::uint32_t group;
  bool operator==(const CellKey& o) const {
    return x == o.x && y == o.y && z == o.z && group == o.group;
  }
};

std::size_t hashOf(const CellKey& k) {
  std::uint64_t h = static_cast<std::uint32_t>(k.x) * 0x9E3779B97F4A7C15ull;
  h = (h ^ (h >> 31)) + static_cast<std::uint32_t>(k.y) * 0xBF58476D1CE4E5B9ull;
  h = (h ^ (h >> 29)) + static_cast<std::uint32_t>(k.z) * 0x94D049BB133111EBull;
  h = (h ^ (h >> 30)) + k.group * 0xD1342543DE82EF95ull;
  return h ^ (h >> 32);
}

struct Distribution {
  CellKey key;
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();  ///< relative to the map's origin
  Eigen::Matrix3f information = Eigen::Matrix3f::Zero();
  std::uint32_t points = 0;
};

}  // namespace

struct DistributionMap::Cells {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  float side = 1;
  std::vector<Distribution> distributions;
  std::vector<std::int32_t> slots = std::vector<std::int32_t>(1024, -1);

  CellKey keyOf(const Eigen::Vector3f& p, std::uint32_t group) const {
    const auto index = [this](float c) { return static_cast<std::int32_t>(std::floor(c / side)); };
    return {index(p.x()), index(p.y()), index(p.z()), group};
  }
  std::size_t slotOf(const CellKey& key) const {
    const std::size_t mask = slots.size() - 1;
    std::size_t slot = hashOf(key) & mask;
    while (slots[slot] >= 0 && !(distributions[slots[slot]].key == key)) slot = (slot + 1) & mask;
    return slot;
  }
  const Distribution* find(const CellKey& key) const {
    const std::int32_t i = slots[slotOf(key)];
    return i < 0 ? nullptr : &distributions[i];
  }
  Distribution& findOrAdd(const CellKey& key) {
    if (2 * distributions.size() >= slots.size()) {
      slots.assign(2 * slots.size(), -1);
      for (std::size_t i = 0; i < distributions.size(); ++i)
        slots[slotOf(distributions[i].key)] = static_cast<std::int32_t>(i);
    }
    const std::size_t slot = slotOf(key);
    if (slots[slot] < 0) {
      slots[slot] = static_cast<std::int32_t>(distributions.size());
      distributions.emplace_back();
      distributions.back().key = key;
    }
    return distributions[slots[slot]];
  }

  /// The nearest distribution of the group in the cell of p and the 26 around it, within the gate.
  const Distribution* nearest(const Eigen::Vector3f& p, std::uint32_t group, float gate) const {
    const CellKey own = keyOf(p, group);
    const Distribution* best = nullptr;
    float best_squared = gate * gate;
    for (std::int32_t dz = -1; dz <= 1; ++dz) {
      for (std::int32_t dy = -1; dy <= 1; ++dy) {
        for (std::int32_t dx = -1; dx <= 1; ++dx) {
          const Distribution* d = find({own.x + dx, own.y + dy, own.z + dz, group});
          if (!d || d->points < kFewestPoints) continue;
          const float squared = (d->mean - p).squaredNorm();
          if (squared < best_squared) {
            best_squared = squared;
            best = d;
          }
        }
      }
    }
    return best;
  }
};

DistributionMap::DistributionMap(const LabelledCloud& map, const LabelSet& labels, double cell_m,
                                 double roughness_m)
    : cells_(std::make_unique<Cells>()) {
  cells_->origin = map.origin;
  cells_->side = static_cast<float>(cell_m);
  std::vector<Eigen::Matrix3f> squares;
  for (const pcl::PointXYZL& point : map.points) {
    const std::uint32_t group = groupOf(labels, point.label);
    const Eigen::Vector3f p = point.getVector3fMap();
    if (group == kNoGroup || !p.allFinite()) continue;
    Distribution& d = cells_->findOrAdd(cells_->keyOf(p, group));
    const auto index = static_cast<std::size_t>(&d - cells_->distributions.data());
    if (squares.size() <= index) squares.resize(index + 1, Eigen::Matrix3f::Zero());
    // Welford's update keeps single precision good far from the origin.
    const Eigen::Vector3f before = p - d.mean;
    d.mean += before / static_cast<float>(++d.points);
    squares[index] += before * (p - d.mean).transpose();
  }
  const auto variance = static_cast<float>(roughness_m * roughness_m);
  for (std::size_t i = 0; i < squares.size(); ++i) {
    Distribution& d = cells_->distributions[i];
    const Eigen::Matrix3f covariance = squares[i] / static_cast<float>(d.points);
    d.information =
        (0.5f * (covariance + covariance.transpose()) + variance * Eigen::Matrix3f::Identity())
            .inverse();
  }
}
DistributionMap::~DistributionMap() = default;
DistributionMap::DistributionMap(DistributionMap&&) noexcept = default;
std::size_t DistributionMap::size() const { return cells_->distributions.size(); }

struct RefineAccess {
  static const DistributionMap::Cells& cells(const DistributionMap& map) { return *map.cells_; }
};

namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;

struct QueryPoint {
  Eigen::Vector3d p;  ///< query frame
  std::uint32_t group;
};

/// At most max_points, evenly spread over the cloud.
std::vector<QueryPoint> choosePoints(const LabelledCloud& query, const LabelSet& labels,
                                     int max_points) {
  std::vector<QueryPoint> all, chosen;
  for (std::size_t i = 0; i < query.size(); ++i) {
    const std::uint32_t group = groupOf(labels, query.points[i].label);
    const Eigen::Vector3d p = query.position(i);
    if (group != kNoGroup && p.allFinite()) all.push_back({p, group});
  }
  const std::size_t count = std::min(all.size(), static_cast<std::size_t>(max_points));
  for (std::size_t k = 0; k < count; ++k) chosen.push_back(all[k * all.size() / count]);
  return chosen;
}

/// One Gauss-Newton system about the sensor: unknown d = (translation, rotation vector), left
/// increment in the map frame.
struct NormalEquations {
  Matrix6d H = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();
  std::vector<double> mahalanobis;  ///< squared, of each point with a partner
};

NormalEquations accumulate(const DistributionMap& map, const std::vector<QueryPoint>& points,
                           const Eigen::Isometry3d& T, const Eigen::Vector3d& sensor_in_map,
                           double gate_m) {
  const auto& cells = RefineAccess::cells(map);
  NormalEquations n;
  for (const QueryPoint& q : points) {
    const Eigen::Vector3d p = T * q.p;
    const Distribution* d =
        cells.nearest((p - cells.origin).cast<float>(), q.group, static_cast<float>(gate_m));
    if (!d) continue;
    const Eigen::Vector3d r = cells.origin + d->mean.cast<double>() - p;
    const Eigen::Matrix3d W = d->information.cast<double>();
    const double m = r.dot(W * r);
    const double weight = 1 / ((1 + m / 4) * (1 + m / 4));
    Eigen::Matrix<double, 3, 6> J;
    const Eigen::Vector3d lever = p - sensor_in_map;
    J << Eigen::Matrix3d::Identity(), (Eigen::Matrix3d() << 0, lever.z(), -lever.y(), -lever.z(), 0,
                                       lever.x(), lever.y(), -lever.x(), 0)
                                          .finished();
    n.H.noalias() += weight * J.transpose() * W * J;
    n.b.noalias() += weight * J.transpose() * (W * r);
    n.mahalanobis.push_back(m);
  }
  return n;
}

Eigen::Isometry3d moved(const Eigen::Isometry3d& T, const Vector6d& d,
                        const Eigen::Vector3d& about) {
  const double angle = d.tail<3>().norm();
  Eigen::Isometry3d step = Eigen::Isometry3d::Identity();
  if (angle > 1e-15)
    step.linear() = Eigen::AngleAxisd(angle, d.tail<3>() / angle).toRotationMatrix();
  step.translation() = about - step.linear() * about + d.head<3>();
  return step * T;
}

/// The rotation since the start may turn about z freely, but hardly tilt. `up`: z of the map in the
/// query, at the start.
void addGravity(NormalEquations& n, const Eigen::Isometry3d& T, const Eigen::Vector3d& up,
                double tilt_sigma_deg) {
  const double information = 1 / std::pow(tilt_sigma_deg * M_PI / 180, 2);
  const Eigen::Vector3d upright =
      (T.linear() * up)
          .cross(Eigen::Vector3d::UnitZ());  // rotation vector that would put it upright
  for (const int axis : {0, 1}) {
    n.H(3 + axis, 3 + axis) += information;
    n.b(3 + axis) += information * upright(axis);
  }
}

/// 0 in the first iteration, 1 from 60 % of them on.
double progressAt(int iteration, const RefineOptions& options) {
  return std::min(1.0, iteration / std::max(1.0, 0.6 * options.iterations));
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Matrix6d covarianceOf(const Matrix6d& information) {
  Matrix6d covariance = kCorrelatedPoints * information.inverse();
  covariance.diagonal().head<3>().array() += kFloor_m * kFloor_m;
  covariance.diagonal().tail<3>().array() += kFloor_rad * kFloor_rad;
  return covariance;
}

}  // namespace

Refinement refine(const DistributionMap& map, const LabelledCloud& query, const LabelSet& labels,
                  const Eigen::Isometry3d& T_map_query, const Eigen::Vector3d& sensor_in_query,
                  const RefineOptions& options) {
  constexpr int kFewestPartners = 50;
  constexpr double kStill = 1e-4;
  const std::vector<QueryPoint> points = choosePoints(query, labels, options.max_points);
  const Eigen::Vector3d up = T_map_query.linear().transpose() * Eigen::Vector3d::UnitZ();
  Refinement result;
  result.T_map_query = T_map_query;
  NormalEquations n;
  for (int i = 0; i < options.iterations; ++i) {
    const double progress = progressAt(i, options);
    const double gate =
        options.first_gate_m + progress * (options.last_gate_m - options.first_gate_m);
    const Eigen::Vector3d sensor = result.T_map_query * sensor_in_query;
    n = accumulate(map, points, result.T_map_query, sensor, gate);
    if (n.mahalanobis.size() < kFewestPartners) return result;
    addGravity(n, result.T_map_query, up, options.tilt_sigma_deg);
    const Vector6d d = n.H.ldlt().solve(n.b);
    if (!d.allFinite()) return result;
    result.T_map_query = moved(result.T_map_query, d, sensor);
    result.iterations = i + 1;
    if (progress == 1 && d.norm() < kStill) break;
  }
  result.overlap = static_cast<double>(n.mahalanobis.size()) / static_cast<double>(points.size());
  result.residual_m = options.roughness_m * std::sqrt(median(n.mahalanobis));
  result.covariance = covarianceOf(n.H);
  const double shift =
      (result.T_map_query * sensor_in_query - T_map_query * sensor_in_query).norm();
  result.converged = shift <= options.max_shift_m;
  return result;
}

}  // namespace xview
