// SPDX-License-Identifier: BSD-3-Clause
#include "voxel_thinner.h"

#include <algorithm>

#include "row_loops.h"

namespace xview {

std::uint64_t VoxelThinner::Voxel::hash() const {
  std::uint64_t h = xy * 0x9E3779B97F4A7C15ull;
  h = (h ^ (h >> 32)) + z_label * 0xBF58476D1CE4E5B9ull + instance * 0x94D049BB133111EBull;
  h = (h ^ (h >> 29)) * 0x2545F4914F6CDD1Dull;
  return h ^ (h >> 32);
}

VoxelThinner::VoxelThinner(const Eigen::Vector3d& origin, double voxel_m, std::size_t expected)
    : origin_(origin), per_metre_(1 / voxel_m) {
  // Few voxels have one point only, and a small table stays in the cache.
  std::size_t capacity = 64;
  while (capacity < expected / 4) capacity *= 2;
  slots_.assign(capacity, 0);
  sums_.reserve(expected / 8);
}

void VoxelThinner::add(const PointRow& row) {
  if (row.size == 0) return;
  findRuns(row);
  for (std::size_t run = 0; run + 1 < run_begin_.size(); ++run)
    addRun(row, run_begin_[run], run_begin_[run + 1]);
}

/// Neighbouring measurements mostly share their voxel.
void VoxelThinner::findRuns(const PointRow& row) {
  const std::size_t count = row.size;
  if (is_first_.size() < count) {
    for (auto* cells : {&cell_x_, &cell_y_, &cell_z_}) cells->resize(count);
    is_first_.resize(count);
  }
  const Eigen::Vector3d start = origin_ * per_metre_;
  cellsOf(row.x.data(), count, per_metre_, start.x(), cell_x_.data());
  cellsOf(row.y.data(), count, per_metre_, start.y(), cell_y_.data());
  cellsOf(row.z.data(), count, per_metre_, start.z(), cell_z_.data());
  std::fill_n(is_first_.begin(), count, std::uint8_t{0});
  for (const auto* cells : {&cell_x_, &cell_y_, &cell_z_})
    markChanges(reinterpret_cast<const std::uint32_t*>(cells->data()), count, is_first_.data());
  markChanges(row.label.data(), count, is_first_.data());
  markChanges(row.instance.data(), count, is_first_.data());
  is_first_[0] = 1;

  run_begin_.resize(count + 1);
  std::size_t runs = 0;
  for (std::size_t i = 0; i < count; ++i) {
    run_begin_[runs] = static_cast<std::uint32_t>(i);
    runs += is_first_[i];
  }
  run_begin_[runs] = static_cast<std::uint32_t>(count);
  run_begin_.resize(runs + 1);
}

void VoxelThinner::addRun(const PointRow& row, std::size_t begin, std::size_t end) {
  const std::int32_t x = cell_x_[begin], y = cell_y_[begin], z = cell_z_[begin];
  if (x == kNoCell || y == kNoCell || z == kNoCell) return;
  const auto pair = [](std::uint32_t high, std::uint32_t low) {
    return static_cast<std::uint64_t>(high) << 32 | low;
  };
  const Voxel voxel{pair(x, y), pair(z, row.label[begin]), row.instance[begin]};
  Sums& sums = findOrAdd(voxel, row, begin);
  float dx = sums.offset[0], dy = sums.offset[1], dz = sums.offset[2], sigma = sums.sigma;
  for (std::size_t i = begin; i < end; ++i) {
    dx += row.x[i] - sums.first[0];
    dy += row.y[i] - sums.first[1];
    dz += row.z[i] - sums.first[2];
    sigma += row.sigma[i];
  }
  sums.offset[0] = dx, sums.offset[1] = dy, sums.offset[2] = dz, sums.sigma = sigma;
  sums.count += static_cast<std::uint32_t>(end - begin);
}

VoxelThinner::Sums& VoxelThinner::findOrAdd(const Voxel& voxel, const PointRow& row,
                                            std::size_t first) {
  const std::size_t mask = slots_.size() - 1;
  std::size_t slot = voxel.hash() & mask;
  while (slots_[slot] != 0) {
    Sums& sums = sums_[slots_[slot] - 1];
    if (sums.voxel == voxel) return sums;
    slot = (slot + 1) & mask;
  }
  sums_.push_back({voxel, 0, {row.x[first], row.y[first], row.z[first]}, {0, 0, 0}, 0});
  slots_[slot] = static_cast<std::uint32_t>(sums_.size());
  if (sums_.size() * 2 > slots_.size()) grow();
  return sums_.back();
}

void VoxelThinner::grow() {
  slots_.assign(slots_.size() * 2, 0);
  const std::size_t mask = slots_.size() - 1;
  for (std::size_t i = 0; i < sums_.size(); ++i) {
    std::size_t slot = sums_[i].voxel.hash() & mask;
    while (slots_[slot] != 0) slot = (slot + 1) & mask;
    slots_[slot] = static_cast<std::uint32_t>(i + 1);
  }
}

LabelledCloud VoxelThinner::finish(std::vector<std::uint32_t>* points_per_voxel) const {
  LabelledCloud thin;
  thin.origin = origin_;
  const std::size_t size = sums_.size();
  thin.points.points.reserve(size);
  if (points_per_voxel) {
    points_per_voxel->clear();
    points_per_voxel->reserve(size);
  }
  for (const Sums& sums : sums_) {
    const float weight = 1.0f / static_cast<float>(sums.count);
    Point point(sums.first[0] + sums.offset[0] * weight, sums.first[1] + sums.offset[1] * weight,
                sums.first[2] + sums.offset[2] * weight,
                static_cast<std::uint32_t>(sums.voxel.z_label));
    point.instance = sums.voxel.instance;
    point.sigma = sums.sigma * weight;
    thin.points.points.push_back(point);
    if (points_per_voxel) points_per_voxel->push_back(sums.count);
  }
  thin.points.width = static_cast<std::uint32_t>(size);
  thin.points.height = 1;
  thin.points.is_dense = true;
  return thin;
}

}  // namespace xview
