// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "xview/graph/blobs.h"

namespace xview {
namespace {

// Cell numbers beyond this do not fit; a point so far away is a fault of the sensor.
constexpr double kMaxCell = 1 << 30;

struct Voxel {
  std::int32_t x, y, z;
  std::uint32_t label, instance;

  bool operator==(const Voxel& o) const {
    return x == o.x && y == o.y && z == o.z && label == o.label && instance == o.instance;
  }
  std::uint64_t hash() const {
    std::uint64_t h = static_cast<std::uint32_t>(x) * 0x9E3779B97F4A7C15ull;
    h = (h ^ (h >> 29)) + static_cast<std::uint32_t>(y) * 0xBF58476D1CE4E5B9ull;
    h = (h ^ (h >> 31)) + static_cast<std::uint32_t>(z) * 0x94D049BB133111EBull;
    h = (h ^ (h >> 30)) + (label * 0x2545F491ull + instance) * 0x9E3779B97F4A7C15ull;
    return h ^ (h >> 32);
  }
};

/// Sums of the points of a voxel, relative to its first point so that they stay small.
struct Sums {
  Voxel voxel;
  Eigen::Vector3f first, offset;
  float range;
  std::uint32_t count;
};

/// Voxels in order of first appearance, found through open addressing.
class VoxelTable {
 public:
  explicit VoxelTable(std::size_t points) {
    // Few voxels have one point only, and a small table stays in the cache.
    std::size_t capacity = 64;
    while (capacity < points / 4) capacity *= 2;
    slots_.assign(capacity, 0);
    sums_.reserve(points / 8);
  }

  Sums& findOrAdd(const Voxel& voxel, const Eigen::Vector3f& p) {
    // Neighbouring measurements mostly share their voxel.
    if (last_ < sums_.size() && sums_[last_].voxel == voxel) return sums_[last_];
    const std::size_t mask = slots_.size() - 1;
    std::size_t slot = voxel.hash() & mask;
    while (slots_[slot] != 0 && !(sums_[slots_[slot] - 1].voxel == voxel)) slot = (slot + 1) & mask;
    if (slots_[slot] == 0) {
      sums_.push_back({voxel, p, Eigen::Vector3f::Zero(), 0, 0});
      slots_[slot] = static_cast<std::uint32_t>(sums_.size());
      last_ = sums_.size() - 1;
      if (sums_.size() * 2 > slots_.size()) grow();
    } else {
      last_ = slots_[slot] - 1;
    }
    return sums_[last_];
  }

  const std::vector<Sums>& sums() const { return sums_; }

 private:
  void grow() {
    slots_.assign(slots_.size() * 2, 0);
    const std::size_t mask = slots_.size() - 1;
    for (std::size_t i = 0; i < sums_.size(); ++i) {
      std::size_t slot = sums_[i].voxel.hash() & mask;
      while (slots_[slot] != 0) slot = (slot + 1) & mask;
      slots_[slot] = static_cast<std::uint32_t>(i + 1);
    }
  }

  std::vector<std::uint32_t> slots_;  ///< 1 + index into sums_, 0 = free
  std::vector<Sums> sums_;
  std::size_t last_ = 0;
};

/// floor without the library call, which costs more than the rest of the loop on baseline x86-64.
std::int32_t floorOf(double value) {
  const auto truncated = static_cast<std::int32_t>(value);
  return truncated - (value < truncated);
}

}  // namespace

LabelledCloud thinByVoxel(const LabelledCloud& cloud, double voxel_m,
                          std::vector<std::uint32_t>* points_per_voxel) {
  if (voxel_m <= 0) {
    if (points_per_voxel) points_per_voxel->assign(cloud.size(), 1);
    return cloud;
  }
  const bool has_instances = cloud.instances.size() == cloud.size();
  const bool has_ranges = cloud.ranges.size() == cloud.size();
  VoxelTable table(cloud.size());
  const double per_metre = 1 / voxel_m;
  const Eigen::Vector3d start = cloud.origin * per_metre;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const pcl::PointXYZL& point = cloud.points.points[i];
    const double x = point.x * per_metre + start.x();
    const double y = point.y * per_metre + start.y();
    const double z = point.z * per_metre + start.z();
    // Written so that it is also false for NaN.
    if (!(std::abs(x) < kMaxCell && std::abs(y) < kMaxCell && std::abs(z) < kMaxCell)) continue;
    const Voxel voxel{floorOf(x), floorOf(y), floorOf(z), point.label,
                      has_instances ? cloud.instances[i] : 0};
    const Eigen::Vector3f p = point.getVector3fMap();
    Sums& sums = table.findOrAdd(voxel, p);
    sums.offset += p - sums.first;
    if (has_ranges) sums.range += cloud.ranges[i];
    ++sums.count;
  }

  LabelledCloud thin;
  thin.origin = cloud.origin;
  const std::size_t size = table.sums().size();
  thin.points.points.reserve(size);
  if (has_instances) thin.instances.reserve(size);
  if (has_ranges) thin.ranges.reserve(size);
  if (points_per_voxel) points_per_voxel->clear();
  for (const Sums& sums : table.sums()) {
    const float weight = 1.0f / static_cast<float>(sums.count);
    const Eigen::Vector3f p = sums.first + sums.offset * weight;
    thin.points.points.emplace_back(p.x(), p.y(), p.z(), sums.voxel.label);
    if (has_instances) thin.instances.push_back(sums.voxel.instance);
    if (has_ranges) thin.ranges.push_back(sums.range * weight);
    if (points_per_voxel) points_per_voxel->push_back(sums.count);
  }
  thin.points.width = static_cast<std::uint32_t>(size);
  thin.points.height = 1;
  thin.points.is_dense = true;
  return thin;
}

}  // namespace xview
