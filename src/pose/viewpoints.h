// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

namespace xview {

/// The poses that a map was seen from, on a grid, to ask which of them saw a place best.
class Viewpoints {
 public:
  explicit Viewpoints(const std::vector<Eigen::Isometry3d>& T_map_sensor);

  /// Unit vector from p to the nearest pose that has p in view; zero if there is none within some
  /// 50 m.
  Eigen::Vector3f directionFrom(const Eigen::Vector3d& p) const;

 private:
  using Cell = std::pair<std::int64_t, std::int64_t>;
  static Cell cellOf(const Eigen::Vector3d& p);

  std::vector<Eigen::Isometry3d> poses_;
  std::map<Cell, std::vector<std::size_t>> grid_;
};

}  // namespace xview
