// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <memory>
#include <vector>

#include "base/cells.h"
#include "xview/base/labelled_cloud.h"

namespace xview {

/// Points of a map that are packed as in its file, and unpacked column by column where somebody
/// asks for them. A column is a square of 64 m from the origin of the cloud, of any height.
class StoredCloud {
 public:
  static constexpr int kColumn_m = 64;

  /// The square of a column of a cloud with this origin.
  static Eigen::AlignedBox2d squareOf(const PlaneCell& column, const Eigen::Vector3d& origin) {
    const Eigen::Vector2d low = origin.head<2>() + kColumn_m * Eigen::Vector2d(column.x, column.y);
    return {low, low + Eigen::Vector2d::Constant(kColumn_m)};
  }

  virtual ~StoredCloud() = default;
  virtual std::size_t size() const = 0;  ///< points
  /// The columns that hold points, sorted.
  virtual std::vector<PlaneCell> columns() const = 0;
  /// The points of a column, from the origin of the cloud; of an empty one none. Thread-safe.
  virtual std::shared_ptr<const LabelledCloud> pointsOf(const PlaneCell& column) const = 0;
};

}  // namespace xview
