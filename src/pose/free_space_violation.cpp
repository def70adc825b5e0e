// SPDX-License-Identifier: BSD-3-Clause
#include "pose/free_space_violation.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace xview::pose {
namespace {

constexpr double kCell_m = 0.5;
constexpr double kReach_m = 40;  ///< of the rays that are followed
constexpr std::size_t kMostRays = 20000;
constexpr double kSigmas = 2;        ///< number of sigmas before its point at which a ray ends
constexpr std::uint8_t kPassed = 2;  ///< number of rays from which on a cell is free
constexpr double kFewest = 30;       ///< distributions that tell anything
/// The null hypothesis: number of displaced poses, and their distance.
constexpr int kNullMoves = 6;
constexpr double kNullMove_m = 2;
/// Who would hardly see through anything at a wrong place either, as from the air, tells nothing.
constexpr double kLeastDisplaced = 0.05;

/// Distributions of the map in what a query has looked at.
struct RayCounts {
  double met = 0;      ///< where something stands in the query as well
  double through = 0;  ///< where rays passed instead

  double observed() const { return met + through; }
  double share() const { return (through + 1) / (observed() + 1); }
};

/// Cells around the way of a query: where anything stands, and how many rays passed.
class SeenSpace {
 public:
  SeenSpace(const RefineQuery& query, const LabelSet& labels) : query_(query) {
    const std::size_t step = std::max<std::size_t>(1, query.cloud.size() / kMostRays);
    Eigen::AlignedBox3d box;
    for (std::size_t i = 0; i < query.cloud.size(); ++i) {
      if (isFollowed(i)) box.extend(query.cloud.position(i)).extend(viewpointOf(i));
    }
    if (box.isEmpty()) return;
    corner_ = box.min() - Eigen::Vector3d::Constant(kCell_m);
    size_ = cellOf(box.max()) + Eigen::Vector3i::Constant(2);
    rays_.assign(static_cast<std::size_t>(size_.cast<std::int64_t>().prod()), 0);
    stands_.assign(rays_.size(), false);
    for (std::size_t i = 0; i < query.cloud.size(); ++i) {
      if (!isFollowed(i)) continue;
      if (i % step == 0) follow(i);
      const std::uint32_t group = matchingGroup(labels, query.cloud.points[i].label);
      if (group != kNoGroup && !isGround(kindOfGroup(group))) standAround(query.cloud.position(i));
    }
  }

  RayCounts at(const DistributionMap& map, const Eigen::Isometry3d& T_map_query) const {
    RayCounts counts;
    if (rays_.empty()) return counts;
    const Eigen::Vector3d half = 0.5 * kCell_m * size_.cast<double>();
    const Eigen::Isometry3d T_query_map = T_map_query.inverse();
    map.forAround(T_map_query * (corner_ + half), half.head<2>().norm(),
                  [&](const Distribution& d, std::uint32_t group) {
                    if (isGround(kindOfGroup(group))) return;
                    const Eigen::Vector3d p_map = map.origin() + d.mean.cast<double>();
                    const Eigen::Vector3i cell = cellOf(T_query_map * p_map);
                    if (!isInside(cell)) return;
                    if (stands_[indexOf(cell)])
                      ++counts.met;
                    else if (rays_[indexOf(cell)] >= kPassed)
                      ++counts.through;
                  });
    return counts;
  }

 private:
  Eigen::Vector3d viewpointOf(std::size_t point) const {
    return query_.poses[query_.cloud.points[point].view].translation();
  }
  bool isFollowed(std::size_t point) const {
    const Point& p = query_.cloud.points[point];
    return p.view < query_.poses.size() && p.getVector3fMap().allFinite() &&
           (query_.cloud.position(point) - viewpointOf(point)).norm() < kReach_m;
  }

  Eigen::Vector3i cellOf(const Eigen::Vector3d& p_query) const {
    return ((p_query - corner_) / kCell_m).array().floor().cast<int>().matrix();
  }
  bool isInside(const Eigen::Vector3i& cell) const {
    return (cell.array() >= 0).all() && (cell.array() < size_.array()).all();
  }
  std::size_t indexOf(const Eigen::Vector3i& cell) const {
    return (static_cast<std::size_t>(cell.z()) * static_cast<std::size_t>(size_.y()) +
            static_cast<std::size_t>(cell.y())) *
               static_cast<std::size_t>(size_.x()) +
           static_cast<std::size_t>(cell.x());
  }

  void follow(std::size_t point) {
    const Eigen::Vector3d from = viewpointOf(point), way = query_.cloud.position(point) - from;
    const double end_m = way.norm() - kCell_m - kSigmas * query_.cloud.points[point].sigma;
    for (double r_m = kCell_m; r_m < end_m; r_m += kCell_m) {
      std::uint8_t& rays = rays_[indexOf(cellOf(from + r_m * way.normalized()))];
      if (rays < kPassed) ++rays;
    }
  }

  /// In its cell and those beside it.
  void standAround(const Eigen::Vector3d& p_query) {
    const Eigen::Vector3i own = cellOf(p_query);
    for (int i = 0; i < 27; ++i) {
      const Eigen::Vector3i cell = own + Eigen::Vector3i(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
      if (isInside(cell)) stands_[indexOf(cell)] = true;
    }
  }

  const RefineQuery& query_;
  Eigen::Vector3d corner_ = Eigen::Vector3d::Zero();
  Eigen::Vector3i size_ = Eigen::Vector3i::Zero();
  std::vector<std::uint8_t> rays_;
  std::vector<bool> stands_;
};

}  // namespace

std::optional<double> freeSpaceViolation(const DistributionMap& map, const RefineQuery& query,
                                         const LabelSet& labels,
                                         const Eigen::Isometry3d& T_map_query) {
  const SeenSpace space(query, labels);
  const RayCounts here = space.at(map, T_map_query);
  if (here.observed() < kFewest) return std::nullopt;
  RayCounts displaced;
  for (int k = 0; k < kNullMoves; ++k) {
    const double angle = 0.3 + 2 * M_PI * k / kNullMoves;
    Eigen::Isometry3d moved = T_map_query;
    moved.pretranslate(kNullMove_m * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0));
    const RayCounts counts = space.at(map, moved);
    displaced.met += counts.met;
    displaced.through += counts.through;
  }
  if (displaced.share() < kLeastDisplaced) return std::nullopt;
  return here.share() / displaced.share();
}

}  // namespace xview::pose
