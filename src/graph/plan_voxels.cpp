// SPDX-License-Identifier: BSD-3-Clause
#include "graph/plan_voxels.h"

namespace xview {
namespace {

constexpr std::size_t kFirstSlots = 1 << 12;
constexpr VoxelKey kKindMask = 0xF;
// The table outgrows the caches: what a vote needs is asked for so many votes ahead.
constexpr std::size_t kSlotAhead = 16, kVoxelAhead = 8;

std::uint64_t hashOf(VoxelKey key) {
  key = (key ^ (key >> 32)) * 0x9E3779B97F4A7C15ull;
  return key ^ (key >> 29);
}

std::uint32_t tagOf(std::uint64_t hash) { return static_cast<std::uint32_t>(hash >> 32); }

}  // namespace

VoxelKey PlanVoxels::keyOf(double x, double y, double z, Kind kind) const {
  const auto index = [this](double p) {
    const double q = p * inverse_side_;
    const auto toward_zero = static_cast<std::int64_t>(q);
    return toward_zero - (q < static_cast<double>(toward_zero));
  };
  const auto ix = static_cast<std::uint64_t>(index(x) + (1 << 20)) & 0x1FFFFF;
  const auto iy = static_cast<std::uint64_t>(index(y) + (1 << 20)) & 0x1FFFFF;
  const auto iz = static_cast<std::uint64_t>(index(z) + (1 << 17)) & 0x3FFFF;
  return (ix << 43) | (iy << 22) | (iz << 4) | static_cast<std::uint64_t>(kind);
}

PlanVoxels::Slot& PlanVoxels::slotOf(VoxelKey key) {
  const std::size_t mask = slots_.size() - 1;
  const std::uint64_t hash = hashOf(key);
  std::size_t i = hash & mask;
  while (slots_[i].voxel >= 0 &&
         !(slots_[i].tag == tagOf(hash) && voxels_[slots_[i].voxel].key == key))
    i = (i + 1) & mask;
  return slots_[i];
}

void PlanVoxels::reserve(std::size_t voxels) {
  std::size_t size = slots_.empty() ? kFirstSlots : slots_.size();
  while (size < 2 * voxels) size *= 2;
  if (size == slots_.size()) return;
  slots_.assign(size, Slot());
  for (std::size_t i = 0; i < voxels_.size(); ++i) {
    if (i + kSlotAhead < voxels_.size()) prefetchSlot(voxels_[i + kSlotAhead].key);
    slotOf(voxels_[i].key) = {tagOf(hashOf(voxels_[i].key)), static_cast<std::int32_t>(i)};
  }
}

void PlanVoxels::prefetchSlot(VoxelKey key) const {
  __builtin_prefetch(&slots_[hashOf(key) & (slots_.size() - 1)], 1);
}

void PlanVoxels::prefetchVoxel(VoxelKey key) const {
  const std::int32_t voxel = slots_[hashOf(key) & (slots_.size() - 1)].voxel;
  if (voxel >= 0) __builtin_prefetch(&voxels_[voxel], 1);
}

PlanVoxel& PlanVoxels::findOrAdd(const PlanVote& vote) {
  Slot& slot = slotOf(vote.key);
  if (slot.voxel < 0) {
    slot = {tagOf(hashOf(vote.key)), static_cast<std::int32_t>(voxels_.size())};
    voxels_.push_back(
        {vote.key, vote.x, vote.y, vote.z, 0, 0, static_cast<Kind>(vote.key & kKindMask)});
  }
  return voxels_[slot.voxel];
}

void PlanVoxels::add(const std::vector<PlanVote>& votes) {
  reserve(voxels_.size() + votes.size());
  for (std::size_t i = 0; i < votes.size(); ++i) {
    if (i + kSlotAhead < votes.size()) prefetchSlot(votes[i + kSlotAhead].key);
    if (i + kVoxelAhead < votes.size()) prefetchVoxel(votes[i + kVoxelAhead].key);
    const PlanVote& vote = votes[i];
    PlanVoxel& voxel = findOrAdd(vote);
    voxel.votes += vote.votes;
    if (vote.near) voxel.near_votes += vote.votes;
    const float share = vote.votes / voxel.votes;
    voxel.x += share * (vote.x - voxel.x);
    voxel.y += share * (vote.y - voxel.y);
    voxel.z += share * (vote.z - voxel.z);
  }
}

}  // namespace xview
