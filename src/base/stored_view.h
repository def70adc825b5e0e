// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/cells.h"
#include "xview/base/bev_grid.h"

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
  virtual std::size_t sampleCount() const = 0;
  /// search::fingerprintOf() all of it.
  virtual std::uint64_t fingerprint() const = 0;
};

/// Adds the columns that a box touches, from the origin of the grid [m].
void addColumns(const Eigen::AlignedBox2d& box, CellIndex& columns);

/// Those columns as one view, in row order, in the grid of `empty`, a view of nothing. Throws
/// Error.
BevGrid gathered(const StoredView& view, const CellIndex& columns, const BevGrid& empty);

}  // namespace xview
