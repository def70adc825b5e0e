// SPDX-License-Identifier: BSD-3-Clause
#include "graph/plan_voxels.h"

#include <cmath>

namespace xview {
namespace {

constexpr std::size_t kFirstSlots = 1 << 12;

/// 21 bits for x and y (a million voxels each way), 18 for z, 4 for the kind.
std::uint64_t voxelKey(double x, double y, double z, Kind kind) {
  const auto ix = static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(x)) + (1 << 20)) & 0x1FFFFF;
  const auto iy = static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(y)) + (1 << 20)) & 0x1FFFFF;
  const auto iz = static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(z)) + (1 << 16)) & 0x3FFFF;
  return (ix << 43) | (iy << 22) | (iz << 4) | static_cast<std::uint64_t>(kind);
}

std::uint64_t scrambled(std::uint64_t key) {
  key *= 0x9E3779B97F4A7C15ull;
  return key ^ (key >> 32);
}

}  // namespace

PlanVoxels::PlanVoxels(double voxel_m) : inverse_side_(1.0 / voxel_m), slots_(kFirstSlots, -1) {}

std::size_t PlanVoxels::slotOf(std::uint64_t key) const {
  const std::size_t mask = slots_.size() - 1;
  std::size_t slot = scrambled(key) & mask;
  while (slots_[slot] >= 0 && keys_[slots_[slot]] != key) slot = (slot + 1) & mask;
  return slot;
}

void PlanVoxels::grow() {
  slots_.assign(slots_.size() * 2, -1);
  for (std::size_t i = 0; i < keys_.size(); ++i) slots_[slotOf(keys_[i])] = static_cast<std::int32_t>(i);
}

void PlanVoxels::add(double x, double y, double z, Kind kind, float votes, bool near) {
  if (voxels_.size() * 2 >= slots_.size()) grow();
  const std::uint64_t key = voxelKey(x * inverse_side_, y * inverse_side_, z * inverse_side_, kind);
  const std::size_t slot = slotOf(key);
  if (slots_[slot] < 0) {
    slots_[slot] = static_cast<std::int32_t>(voxels_.size());
    keys_.push_back(key);
    voxels_.push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z), 0, 0, kind});
  }
  PlanVoxel& voxel = voxels_[slots_[slot]];
  voxel.votes += votes;
  if (near) voxel.near_votes += votes;
  const float share = voxel.votes > 0 ? votes / voxel.votes : 0.f;
  voxel.x += share * (static_cast<float>(x) - voxel.x);
  voxel.y += share * (static_cast<float>(y) - voxel.y);
  voxel.z += share * (static_cast<float>(z) - voxel.z);
}

}  // namespace xview
