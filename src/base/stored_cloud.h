// SPDX-License-Identifier: BSD-3-Clause
#pragma once

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

  virtual ~StoredCloud() = default;
  virtual std::size_t size() const = 0;  ///< points
  /// The columns that hold points, sorted.
  virtual std::vector<PlaneCell> columns() const = 0;
  /// The points of a column, from the origin of the cloud; of an empty one none. Thread-safe.
  virtual std::shared_ptr<const LabelledCloud> pointsOf(const PlaneCell& column) const = 0;
};

}  // namespace xview
