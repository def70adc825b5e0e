// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/cells.h"
#include "pose/distribution_map.h"

namespace xview::pose {

// Points in cells, each of which becomes a distribution.

constexpr std::uint32_t kFewestPoints = 4;  ///< of a distribution

/// A cell of a group; cells are counted from the origin of the map.
struct CellKey {
  std::int32_t x, y, z;
  std::uint32_t group;

  bool operator==(const CellKey& o) const {
    return x == o.x && y == o.y && z == o.z && group == o.group;
  }
  /// Cells in a row of eight along x lie next to one another in a hash table: neighbours share its
  /// cache lines.
  std::uint64_t hash() const {
    constexpr int kRowBits = 3;
    std::uint64_t h = static_cast<std::uint32_t>(x >> kRowBits) * 0x9E3779B97F4A7C15ull;
    h = (h ^ (h >> 31)) + static_cast<std::uint32_t>(y) * 0xBF58476D1CE4E5B9ull;
    h = (h ^ (h >> 29)) + static_cast<std::uint32_t>(z) * 0x94D049BB133111EBull;
    h = (h ^ (h >> 30)) + group * 0xD1342543DE82EF95ull;
    h ^= h >> 32;
    return (h << kRowBits) | static_cast<std::uint64_t>(x & ((1 << kRowBits) - 1));
  }
};

inline CellKey cellOf(const Eigen::Vector3f& p, std::uint32_t group, float side) {
  return {floorToInt(p.x() / side), floorToInt(p.y() / side), floorToInt(p.z() / side), group};
}

/// A distribution; while points are still added, `information` is the sum of squares about the
/// mean.
struct Cell {
  CellKey key;
  Distribution distribution{};
  std::uint32_t points = 0;

  /// Welford's update keeps single precision good far from the origin.
  void add(const Eigen::Vector3f& p) {
    const Eigen::Vector3f before = p - distribution.mean;
    distribution.mean += before / static_cast<float>(++points);
    distribution.information += before * (p - distribution.mean).transpose();
  }
  void add(const Cell& other) {
    const auto n = static_cast<float>(points), m = static_cast<float>(other.points);
    const Eigen::Vector3f between = other.distribution.mean - distribution.mean;
    distribution.mean += m / (n + m) * between;
    distribution.information +=
        other.distribution.information + n * m / (n + m) * between * between.transpose();
    points += other.points;
  }
  Eigen::Matrix3f covariance() const {
    return distribution.information / static_cast<float>(points);
  }
};

using Cells = CellTable<Cell>;

inline Cell& cellIn(Cells& cells, const CellKey& key) {
  return cells[cells.numberOf(key, [&] { return Cell{key}; })];
}

/// The cells of a tile. Most that are asked for are empty: one bit per cell tells, with groups and
/// heights folded.
class TileTable {
 public:
  explicit TileTable(Cells cells) : cells_(std::move(cells)) {
    for (const Cell& cell : cells_.entries()) {
      if (cell.points < kFewestPoints) continue;
      const std::uint32_t bit = bitOf(cell.key);
      marks_[bit >> 6] |= std::uint64_t{1} << (bit & 63);
      const std::uint32_t place = bit & kPlaceMask;
      held_[place >> 6] |= std::uint64_t{1} << (place & 63);
    }
  }
  /// Of any group; heights that are 16 cells apart are taken for one.
  bool holdsAnything(const CellKey& key) const {
    const std::uint32_t place = bitOf(key) & kPlaceMask;
    return (held_[place >> 6] >> (place & 63)) & 1;
  }
  /// Null if there are too few points.
  const Distribution* find(const CellKey& key) const {
    const std::uint32_t bit = bitOf(key);
    if (!((marks_[bit >> 6] >> (bit & 63)) & 1)) return nullptr;
    const std::int32_t number = cells_.find(key);
    if (number < 0) return nullptr;
    const Cell& cell = cells_[static_cast<std::size_t>(number)];
    return cell.points >= kFewestPoints ? &cell.distribution : nullptr;
  }
  std::size_t size() const { return cells_.size(); }
  template <class Visit>
  void forAll(const Visit& visit) const {
    for (const Cell& cell : cells_.entries()) {
      if (cell.points >= kFewestPoints) visit(cell.distribution, cell.key.group);
    }
  }

 private:
  /// Neighbours have different bits, and so have most groups.
  static std::uint32_t bitOf(const CellKey& k) {
    return (static_cast<std::uint32_t>(k.x) & 31) | (static_cast<std::uint32_t>(k.y) & 31) << 5 |
           (static_cast<std::uint32_t>(k.z) & 15) << 10 | (k.group & 7) << 14;
  }

  static constexpr std::uint32_t kPlaceMask = (1u << 14) - 1;  ///< a bit but for its group

  Cells cells_;
  std::vector<std::uint64_t> marks_ = std::vector<std::uint64_t>((1u << 17) / 64, 0);
  std::vector<std::uint64_t> held_ = std::vector<std::uint64_t>((kPlaceMask + 1) / 64, 0);
};

/// Information of a distribution about a position, less that of a cell of this side filled evenly,
/// and its part within the surface.
Eigen::Matrix3f surplusInformation(const Eigen::Matrix3f& covariance, float side, float variance,
                                   float within);

/// What the points of the cells around say of a cell that has few itself. One beam over a surface,
/// a level line, tells no more than its direction.
bool tellsShape(const Cell& cell);

/// The mean of a cell, laid on the surface that the points around it form.
Eigen::Vector3f laidOn(const Cell& around, const Eigen::Vector3f& mean);

/// Median spread across the surfaces [m].
float medianThickness(const std::vector<Cell>& cells);

}  // namespace xview::pose
