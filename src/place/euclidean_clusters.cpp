// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "base/cells.h"
#include "place/blobs.h"
#include "xview/base/error.h"

namespace xview {
namespace {

// Two points within tolerance are at most two cells apart along each axis.
constexpr std::uint64_t kReach = 2;
constexpr double kMaxCellsPerAxis = 1 << 20;

struct SortedPoint {
  std::uint64_t key;
  std::uint32_t index;
  bool operator<(const SortedPoint& o) const {
    return key != o.key ? key < o.key : index < o.index;
  }
};

/// A cell of side tolerance / sqrt(3): all points in it belong together.
struct Cell {
  std::uint64_t key;
  std::uint32_t begin, end;  ///< its points in sorted order
  Eigen::Vector3f min, max;  ///< tight bounds of them
};

/// Position of a cell as one number: x in the lowest bits, then y, then z, with kReach empty cells
/// around, so that a step to a neighbour is the addition of a constant and never reaches into
/// another row.
struct KeyLayout {
  std::uint64_t step_y = 0, step_z = 0;
};

int bitsFor(std::uint64_t count) {
  int bits = 1;
  while ((std::uint64_t{1} << bits) < count) ++bits;
  return bits;
}

/// Number of the cell along one axis for each coordinate, counted from the smallest.
std::vector<std::uint32_t> cellsAlongAxis(const std::vector<double>& coordinates, double side) {
  const double low = *std::min_element(coordinates.begin(), coordinates.end());
  const double high = *std::max_element(coordinates.begin(), coordinates.end());
  std::vector<std::uint32_t> cells(coordinates.size());
  if ((high - low) / side < kMaxCellsPerAxis) {
    const double per_metre = 1 / side;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      cells[i] = static_cast<std::uint32_t>((coordinates[i] - low) * per_metre);
    }
    return cells;
  }
  // A stray point far away. Count from zero, where doubles are finest, and close the gaps: wider
  // than the reach says no more than the reach plus one.
  std::vector<std::pair<double, std::size_t>> sorted(coordinates.size());
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    sorted[i] = {std::floor(coordinates[i] / side), i};
  }
  std::sort(sorted.begin(), sorted.end());
  double number = 0;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    if (i > 0) number += std::min(sorted[i].first - sorted[i - 1].first, kReach + 1.0);
    cells[sorted[i].second] = static_cast<std::uint32_t>(number);
  }
  if (number >= kMaxCellsPerAxis) {
    throw Error("points to cluster",
                "expected a spread below " + std::to_string(kMaxCellsPerAxis * side) +
                    " m at this tolerance, found " + std::to_string(high - low));
  }
  return cells;
}

/// Sorts by key, then index. Linear: 11 bits at a time, lowest first.
void sortByKey(std::vector<SortedPoint>& points, int bits) {
  constexpr int kDigit = 11;
  if (points.size() < 512) {
    std::sort(points.begin(), points.end());
    return;
  }
  std::vector<SortedPoint> other(points.size());
  for (int shift = 0; shift < bits; shift += kDigit) {
    std::array<std::uint32_t, 1 << kDigit> start{};
    const auto digit = [shift](const SortedPoint& p) {
      return (p.key >> shift) & ((1u << kDigit) - 1);
    };
    for (const SortedPoint& p : points) ++start[digit(p)];
    std::uint32_t sum = 0;
    for (std::uint32_t& s : start) sum += std::exchange(s, sum);
    for (const SortedPoint& p : points) other[start[digit(p)]++] = p;
    points.swap(other);
  }
}

/// Squared distance in single precision with the operations of FLANN in their order, so that the
/// answers agree bit by bit.
float distance2(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  const float dx = a.x() - b.x(), dy = a.y() - b.y(), dz = a.z() - b.z();
  return dx * dx + dy * dy + dz * dz;
}

/// The points of one call in cells, and the search for touching cells.
class CellGrid {
 public:
  CellGrid(const std::vector<Eigen::Vector3f>& points, const std::vector<std::uint32_t>& finite,
           float tolerance_m);

  /// Component of each cell.
  DisjointSets connect() const {
    DisjointSets components(cells_.size());
    // Direct neighbours first: afterwards nearly all cells further apart are known to be connected,
    // which saves looking at their points.
    connectWithin(1, components);
    connectWithin(kReach, components);
    return components;
  }

  const std::vector<Cell>& cells() const { return cells_; }
  const std::vector<SortedPoint>& order() const { return order_; }

 private:
  void sortIntoCells(const std::vector<Eigen::Vector3f>& points,
                     const std::vector<std::uint32_t>& finite, double side) {
    std::array<std::vector<std::uint32_t>, 3> cells;
    std::array<int, 3> bits;
    std::vector<double> coordinates(finite.size());
    for (int axis = 0; axis < 3; ++axis) {
      for (std::size_t i = 0; i < finite.size(); ++i) coordinates[i] = points[finite[i]][axis];
      cells[axis] = cellsAlongAxis(coordinates, side);
      const std::uint64_t last = *std::max_element(cells[axis].begin(), cells[axis].end());
      bits[axis] = bitsFor(last + 1 + 2 * kReach);
    }
    layout_.step_y = std::uint64_t{1} << bits[0];
    layout_.step_z = std::uint64_t{1} << (bits[0] + bits[1]);
    order_.resize(finite.size());
    for (std::size_t i = 0; i < finite.size(); ++i) {
      order_[i] = {(cells[2][i] + kReach) * layout_.step_z +
                       (cells[1][i] + kReach) * layout_.step_y + (cells[0][i] + kReach),
                   finite[i]};
    }
    sortByKey(order_, bits[0] + bits[1] + bits[2]);
  }

  /// Looks at all pairs of cells at most `reach` apart along each axis, each pair once: for every
  /// row of cells ahead, a cursor follows the cells in sorted order.
  void connectWithin(std::uint64_t reach, DisjointSets& components) const {
    std::vector<std::uint64_t> rows;  // key difference to the first cell of a row
    const std::uint64_t width = 2 * reach + 1;
    for (std::uint64_t dz = 0; dz <= reach; ++dz) {
      for (std::uint64_t dy = 0; dy < width; ++dy) {
        if (dz == 0 && dy <= reach) continue;
        rows.push_back(dz * layout_.step_z + (dy - reach) * layout_.step_y - reach);
      }
    }
    std::vector<std::size_t> cursor(rows.size(), 0);
    const auto connectPair = [&](std::uint32_t a, std::uint32_t b) {
      if (components.find(a) != components.find(b) && touch(cells_[a], cells_[b]))
        components.unite(a, b);
    };
    for (std::uint32_t c = 0; c < cells_.size(); ++c) {
      const std::uint64_t key = cells_[c].key;
      for (std::uint32_t q = c + 1; q < cells_.size() && cells_[q].key <= key + reach; ++q) {
        connectPair(c, q);
      }
      for (std::size_t r = 0; r < rows.size(); ++r) {
        const std::uint64_t first = key + rows[r];
        while (cursor[r] < cells_.size() && cells_[cursor[r]].key < first) ++cursor[r];
        for (std::size_t q = cursor[r]; q < cells_.size() && cells_[q].key < first + width; ++q) {
          connectPair(c, static_cast<std::uint32_t>(q));
        }
      }
    }
  }

  bool touch(const Cell& a, const Cell& b) const {
    const float margin2 = tolerance2_ * (1 + 1e-5f);  // the bounds are rounded, too
    for (std::uint32_t i = a.begin; i < a.end; ++i) {
      const Eigen::Vector3f nearest = points_[i].cwiseMax(b.min).cwiseMin(b.max);
      if (distance2(points_[i], nearest) > margin2) continue;
      for (std::uint32_t j = b.begin; j < b.end; ++j) {
        if (distance2(points_[i], points_[j]) < tolerance2_) return true;
      }
    }
    return false;
  }

  KeyLayout layout_;
  float tolerance2_;
  std::vector<SortedPoint> order_;
  std::vector<Eigen::Vector3f> points_;  ///< in sorted order
  std::vector<Cell> cells_;              ///< sorted by key
};

CellGrid::CellGrid(const std::vector<Eigen::Vector3f>& points,
                   const std::vector<std::uint32_t>& finite, float tolerance_m)
    : tolerance2_(static_cast<float>(static_cast<double>(tolerance_m) * tolerance_m)) {
  // A little smaller than tolerance / sqrt(3), so that rounding cannot part two points of a cell.
  sortIntoCells(points, finite, tolerance_m / std::sqrt(3.0) * (1 - 1e-5));
  points_.reserve(order_.size());
  for (std::uint32_t i = 0; i < order_.size(); ++i) {
    const Eigen::Vector3f& p = points[order_[i].index];
    points_.push_back(p);
    if (cells_.empty() || cells_.back().key != order_[i].key) {
      cells_.push_back({order_[i].key, i, i, p, p});
    }
    Cell& cell = cells_.back();
    cell.end = i + 1;
    cell.min = cell.min.cwiseMin(p);
    cell.max = cell.max.cwiseMax(p);
  }
}

}  // namespace

std::vector<int> euclideanClusters(const std::vector<Eigen::Vector3f>& points, float tolerance_m,
                                   int min_points) {
  std::vector<int> cluster_of_point(points.size(), -1);
  std::vector<std::uint32_t> finite;
  finite.reserve(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (points[i].allFinite()) finite.push_back(i);
  }
  if (finite.empty()) return cluster_of_point;

  const CellGrid grid(points, finite, tolerance_m);
  DisjointSets components = grid.connect();
  std::vector<std::uint32_t> root_of_point(points.size());
  std::vector<int> size(grid.cells().size(), 0);
  for (std::uint32_t c = 0; c < grid.cells().size(); ++c) {
    const std::uint32_t root = components.find(c);
    const Cell& cell = grid.cells()[c];
    size[root] += static_cast<int>(cell.end - cell.begin);
    for (std::uint32_t i = cell.begin; i < cell.end; ++i)
      root_of_point[grid.order()[i].index] = root;
  }
  std::vector<int> number(grid.cells().size(), -1);
  int clusters = 0;
  for (const std::uint32_t i : finite) {
    const std::uint32_t root = root_of_point[i];
    if (size[root] < min_points) continue;
    if (number[root] < 0) number[root] = clusters++;
    cluster_of_point[i] = number[root];
  }
  return cluster_of_point;
}

}  // namespace xview
