// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "xview/pose/refine.h"
#include "xview/types/labels.h"

namespace xview {

constexpr std::uint32_t kNoGroup = 0xFFFFFFFF;

/// Points match within a group: a kind of thing, or one class if its kind is not known. Lane
/// markings lie on the road. kNoGroup for what moves and what is ignored.
std::uint32_t matchingGroup(const LabelSet& labels, std::uint32_t label);

/// A cell of a group; cells are counted from the origin of the map.
struct CellKey {
  std::int32_t x, y, z;
  std::uint32_t group;
  bool operator==(const CellKey& o) const {
    return x == o.x && y == o.y && z == o.z && group == o.group;
  }
};

struct Distribution {
  CellKey key;
  Eigen::Vector3f mean = Eigen::Vector3f::Zero();         ///< relative to the map's origin
  Eigen::Matrix3f information = Eigen::Matrix3f::Zero();  ///< more than an even cell has [1/m^2]
  Eigen::Vector3f view = Eigen::Vector3f::Zero();  ///< unit vector to who saw it; zero if unknown
  std::uint32_t points = 0;
};

/// Distributions by cell and group, in a hash table with open addresses.
class DistributionCells {
 public:
  DistributionCells(const Eigen::Vector3d& origin, double side)
      : origin_(origin), side_(static_cast<float>(side)) {}

  static const DistributionCells& of(const DistributionMap& map) { return *map.cells_; }

  const Eigen::Vector3d& origin() const { return origin_; }
  float side() const { return side_; }
  std::vector<Distribution>& distributions() { return distributions_; }
  const std::vector<Distribution>& distributions() const { return distributions_; }

  Distribution& findOrAdd(const Eigen::Vector3f& p, std::uint32_t group);
  /// The nearest distribution of the group in the cell of p and the 26 around it, within the gate.
  const Distribution* nearest(const Eigen::Vector3f& p, std::uint32_t group, float gate) const;

 private:
  CellKey keyOf(const Eigen::Vector3f& p, std::uint32_t group) const {
    const auto index = [this](float c) { return static_cast<std::int32_t>(std::floor(c / side_)); };
    return {index(p.x()), index(p.y()), index(p.z()), group};
  }
  /// A place in the hash table; the tag tells most other cells apart without a look at them.
  struct Slot {
    std::int32_t distribution = -1;  ///< -1: free
    std::uint32_t tag = 0;
  };
  /// Where a cell is, or where it would be put.
  std::size_t slotOf(const CellKey& key) const;

  Eigen::Vector3d origin_;
  float side_;
  std::vector<Distribution> distributions_;
  std::vector<Slot> slots_ = std::vector<Slot>(1024);
};

}  // namespace xview
