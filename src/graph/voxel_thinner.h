// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "point_row.h"
#include "xview/types/labelled_cloud.h"

namespace xview {

/// What thinByVoxel does, for points that come row by row and need never be held all at once.
class VoxelThinner {
 public:
  /// Points are relative to `origin`; `expected` of them, more or less.
  VoxelThinner(const Eigen::Vector3d& origin, double voxel_m, std::size_t expected);

  void add(const PointRow& row);

  /// `points_per_voxel` receives how many points each one stands for, if it is given.
  LabelledCloud finish(std::vector<std::uint32_t>* points_per_voxel) const;

 private:
  struct Voxel {
    std::uint64_t xy, z_label;
    std::uint32_t instance;
    bool operator==(const Voxel& o) const {
      return xy == o.xy && z_label == o.z_label && instance == o.instance;
    }
    std::uint64_t hash() const;
  };

  /// Sums of the points of a voxel, relative to its first point so that they stay small.
  struct Sums {
    Voxel voxel;
    std::uint32_t count;
    float first[3], offset[3];
    float sigma;
  };

  void findRuns(const PointRow& row);
  void addRun(const PointRow& row, std::size_t begin, std::size_t end);
  Sums& findOrAdd(const Voxel& voxel, const PointRow& row, std::size_t first);
  void grow();

  Eigen::Vector3d origin_;
  double per_metre_;
  std::vector<Sums> sums_;            ///< in order of first appearance
  std::vector<std::uint32_t> slots_;  ///< open addressing: 1 + index into sums_, 0 = free
  std::vector<std::int32_t> cell_x_, cell_y_, cell_z_;
  std::vector<std::uint8_t> is_first_;    ///< of a run of points in one voxel
  std::vector<std::uint32_t> run_begin_;  ///< and the end
};

}  // namespace xview
