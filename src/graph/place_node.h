// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "xview/types/graph.h"

namespace xview {

/// Cell of a lattice, for one class.
struct CellKey {
  std::int64_t x = 0, y = 0, z = 0;
  std::uint32_t label = 0;

  bool operator==(const CellKey& o) const {
    return x == o.x && y == o.y && z == o.z && label == o.label;
  }
};

struct CellKeyHash {
  std::size_t operator()(const CellKey& k) const {
    std::uint64_t h = static_cast<std::uint64_t>(k.x) * 0x9E3779B97F4A7C15ull;
    h = (h ^ (h >> 29)) + static_cast<std::uint64_t>(k.y) * 0xBF58476D1CE4E5B9ull;
    h = (h ^ (h >> 31)) + static_cast<std::uint64_t>(k.z) * 0x94D049BB133111EBull;
    h = (h ^ (h >> 30)) + k.label * 0xD1342543DE82EF95ull;
    return h ^ (h >> 32);
  }
};

CellKey cellOf(const Eigen::Vector3d& p, double side, std::uint32_t label);

/// A vertex in the making. Sums are relative to the first position, so that they stay small.
struct Node {
  Vertex vertex;  ///< position, extent: kept up to date
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();         ///< weight * (position - first)
  Eigen::Vector3d extent_sum = Eigen::Vector3d::Zero();  ///< weight * extent
  double square_sum = 0;                                 ///< weight * |position - first|^2
  double weight = 0;
  Eigen::Vector3d min = Eigen::Vector3d::Zero(), max = Eigen::Vector3d::Zero();  ///< surfaces only
  std::vector<std::int64_t> frames;  ///< that saw it, counted from 1; objects of running_mean only
  bool is_surface = false;

  Eigen::Vector3d meanOffset() const { return sum / weight; }
};

/// Counts the frame once, however many blobs or points of it arrive.
void countFrame(Vertex& vertex, std::int64_t frame);

/// Adds the observations of the other one.
void join(Node& node, const Node& other);

}  // namespace xview
