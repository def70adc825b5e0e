// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "xview/types/labels.h"

namespace xview {

/// Votes of one kind in one voxel.
struct PlanVoxel {
  float x = 0, y = 0, z = 0;  ///< vote-weighted mean, relative to the plan origin [m]
  float votes = 0;
  float near_votes = 0;  ///< of these, measured near enough for thin objects
  Kind kind = Kind::none;
};

/// Hash of (voxel, kind) -> votes; open addressing, order of first appearance kept in voxels().
class PlanVoxels {
 public:
  explicit PlanVoxels(double voxel_m);
  void add(double x, double y, double z, Kind kind, float votes, bool near);
  const std::vector<PlanVoxel>& voxels() const { return voxels_; }

 private:
  void grow();
  std::size_t slotOf(std::uint64_t key) const;

  double inverse_side_;
  std::vector<PlanVoxel> voxels_;
  std::vector<std::uint64_t> keys_;   ///< of each voxel
  std::vector<std::int32_t> slots_;   ///< index into voxels_, or -1
};

}  // namespace xview
