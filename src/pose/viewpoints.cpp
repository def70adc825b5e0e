// SPDX-License-Identifier: BSD-3-Clause
#include "viewpoints.h"

#include <cmath>

namespace xview {
namespace {

constexpr double kCell_m = 25;
constexpr std::int64_t kCellsAround = 2;

/// Cameras look along their z axis; where it points up it is that of a LiDAR, which sees all
/// around.
bool hasInView(const Eigen::Isometry3d& T_map_sensor, const Eigen::Vector3d& p) {
  constexpr double kUp = 0.7;
  constexpr double kHalfView = 0.64;  // cosine of 50 degrees
  const Eigen::Vector3d axis = T_map_sensor.linear().col(2);
  const Eigen::Vector3d ray = p - T_map_sensor.translation();
  return axis.z() > kUp || axis.dot(ray) > kHalfView * ray.norm();
}

}  // namespace

Viewpoints::Viewpoints(const std::vector<Eigen::Isometry3d>& T_map_sensor) {
  for (const Eigen::Isometry3d& T : T_map_sensor) {
    if (!T.matrix().allFinite()) continue;
    grid_[cellOf(T.translation())].push_back(poses_.size());
    poses_.push_back(T);
  }
}

Viewpoints::Cell Viewpoints::cellOf(const Eigen::Vector3d& p) {
  return {static_cast<std::int64_t>(std::floor(p.x() / kCell_m)),
          static_cast<std::int64_t>(std::floor(p.y() / kCell_m))};
}

Eigen::Vector3f Viewpoints::directionFrom(const Eigen::Vector3d& p) const {
  const auto [x, y] = cellOf(p);
  const Eigen::Isometry3d* nearest = nullptr;
  double nearest_squared = INFINITY;
  for (std::int64_t dy = -kCellsAround; dy <= kCellsAround; ++dy) {
    for (std::int64_t dx = -kCellsAround; dx <= kCellsAround; ++dx) {
      const auto cell = grid_.find({x + dx, y + dy});
      if (cell == grid_.end()) continue;
      for (const std::size_t i : cell->second) {
        const double squared = (p - poses_[i].translation()).squaredNorm();
        if (squared < nearest_squared && hasInView(poses_[i], p)) {
          nearest_squared = squared;
          nearest = &poses_[i];
        }
      }
    }
  }
  if (!nearest || nearest_squared == 0) return Eigen::Vector3f::Zero();
  return ((nearest->translation() - p) / std::sqrt(nearest_squared)).cast<float>();
}

}  // namespace xview
