// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "graph/chunked_vector.h"
#include "xview/types/labels.h"

namespace xview {

/// A voxel and a kind as a number: 21 bits for each of x and y (two million voxels), 18 for z, 4
/// for the kind. Larger coordinates wrap around.
using VoxelKey = std::uint64_t;
/// True for two kinds in one voxel.
inline bool samePlace(VoxelKey a, VoxelKey b) { return a >> 4 == b >> 4; }

/// A labelled point and what it counts.
struct PlanVote {
  VoxelKey key = 0;
  float x = 0, y = 0, z = 0;  ///< relative to the plan origin [m]
  float votes = 0;
  bool near = false;  ///< measured near enough for thin objects
};

/// Votes of one kind in one voxel.
struct PlanVoxel {
  VoxelKey key = 0;
  float x = 0, y = 0, z = 0;  ///< vote-weighted mean, relative to the plan origin [m]
  float votes = 0;
  float near_votes = 0;  ///< of these, measured near enough for thin objects
  Kind kind = Kind::none;
};

/// Sums of votes per voxel and kind, in order of first appearance.
class PlanVoxels {
 public:
  explicit PlanVoxels(double voxel_m) : inverse_side_(1.0 / voxel_m) {}
  VoxelKey keyOf(double x, double y, double z, Kind kind) const;
  void add(const std::vector<PlanVote>& votes);
  const ChunkedVector<PlanVoxel>& voxels() const { return voxels_; }

 private:
  /// Of an open-addressing hash table with linear probing.
  struct Slot {
    std::uint32_t tag = 0;    ///< upper half of the hash: other voxels are seldom looked at
    std::int32_t voxel = -1;  ///< index into voxels_
  };
  void reserve(std::size_t voxels);
  Slot& slotOf(VoxelKey key);
  void prefetchSlot(VoxelKey key) const;
  void prefetchVoxel(VoxelKey key) const;
  PlanVoxel& findOrAdd(const PlanVote& vote);

  double inverse_side_;
  ChunkedVector<PlanVoxel> voxels_;
  std::vector<Slot> slots_;  ///< a power of two of them, or none
};

}  // namespace xview
