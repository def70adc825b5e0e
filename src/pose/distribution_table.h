// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace xview {

/// A cell of a group; cells are counted from the origin of the map.
struct CellKey {
  std::int32_t x, y, z;
  std::uint32_t group;
  bool operator==(const CellKey& o) const {
    return x == o.x && y == o.y && z == o.z && group == o.group;
  }
  std::uint64_t hash() const;  ///< neighbours along x have numbers that follow one another
};

inline CellKey cellOf(const Eigen::Vector3f& p, std::uint32_t group, float side) {
  // std::floor is a library call on baseline x86-64.
  const auto index = [side](float c) {
    const auto towards_zero = static_cast<std::int32_t>(c / side);
    return towards_zero - (c / side < static_cast<float>(towards_zero));
  };
  return {index(p.x()), index(p.y()), index(p.z()), group};
}

struct Distribution {
  CellKey key;
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();         ///< relative to the map's origin
  Eigen::Matrix3f information = Eigen::Matrix3f::Zero();  ///< more than an even cell has [1/m^2]
  Eigen::Vector3f view = Eigen::Vector3f::Zero();  ///< unit vector to who saw it; zero if unknown
  std::uint32_t points = 0;
};

/// Distributions by cell and group, in a hash table with open addresses.
class DistributionTable {
 public:
  Distribution& findOrAdd(const CellKey& key);
  const Distribution* find(const CellKey& key) const;  ///< null if there is none

  /// Marks the cells that have a distribution of so many points.
  void mark(std::uint32_t fewest_points);
  /// False for most cells that were not marked, true for all that were.
  bool mayBeMarked(const CellKey& key) const {
    const std::uint32_t bit = bitOf(key);
    return (marks_[bit >> 6] >> (bit & 63)) & 1;
  }

  std::vector<Distribution>& distributions() { return distributions_; }
  const std::vector<Distribution>& distributions() const { return distributions_; }

 private:
  /// A place in the hash table; the tag tells most other cells apart without a look at them.
  struct Slot {
    std::int32_t distribution = -1;  ///< -1: free
    std::uint32_t tag = 0;
  };
  /// Where a cell is, or where it would be put.
  std::size_t slotOf(const CellKey& key, std::uint64_t hash) const;

  /// Neighbours have different bits, and so have most groups.
  static std::uint32_t bitOf(const CellKey& k) {
    return (static_cast<std::uint32_t>(k.x) & 31) | (static_cast<std::uint32_t>(k.y) & 31) << 5 |
           (static_cast<std::uint32_t>(k.z) & 15) << 10 | (k.group & 7) << 14;
  }

  std::vector<Distribution> distributions_;
  std::vector<Slot> slots_ = std::vector<Slot>(64);
  std::vector<std::uint64_t> marks_;  ///< one bit per cell of a tile, groups and heights folded
};

}  // namespace xview
