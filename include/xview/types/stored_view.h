// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "xview/types/bev_grid.h"
#include "xview/types/cells.h"

namespace xview {

/// The bird's-eye view of a map that is packed as in its file, and unpacked column by column where
/// somebody asks for it. A column is a square of 64 m from the origin of the grid.
class StoredView {
 public:
  static constexpr int kColumn_m = 64;

  virtual ~StoredView() = default;
  /// The columns that hold samples or seen cells, sorted.
  virtual std::vector<PlaneCell> columns() const = 0;
  /// Samples and seen cells of a column, in the grid of the map; of an empty one none. Thread-safe.
  /// Throws Error if the file was damaged.
  virtual std::shared_ptr<const BevGrid> partOf(const PlaneCell& column) const = 0;
  /// All of it, unpacked at the first call. Thread-safe; throws Error.
  virtual const BevGrid& whole() const = 0;
};

}  // namespace xview
