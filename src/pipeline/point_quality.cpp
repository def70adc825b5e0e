// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/point_quality.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <unordered_map>

namespace xview {
namespace {

constexpr double kCell_m = 1.5;
constexpr float kGood_m = 0.1f;  ///< known well enough anywhere
constexpr float kWorse = 1.5f;   ///< times as uncertain as the best ones is too uncertain
constexpr std::uint32_t kBest =
    8;  ///< so many points are the best ones; a few may be known well by mistake

/// Steps of the standard deviation, a sixth each: 0.1 m to 1.5 m, everything above in the last one.
constexpr int kSteps = 18;
constexpr float kStep = 1.1666f;

int stepOf(float sigma_m) {
  int step = 0;
  for (float limit = kGood_m; sigma_m > limit && step + 1 < kSteps; limit *= kStep) ++step;
  return step;
}

float upperEnd(int step) { return kGood_m * std::pow(kStep, static_cast<float>(step)); }

struct Cell {
  std::int64_t x, y, z;
  std::uint32_t label;
  bool operator==(const Cell& o) const {
    return x == o.x && y == o.y && z == o.z && label == o.label;
  }
  std::uint64_t hash() const {
    std::uint64_t h = static_cast<std::uint64_t>(x) * 0x9E3779B97F4A7C15ull;
    h = (h ^ (h >> 31)) + static_cast<std::uint64_t>(y) * 0xBF58476D1CE4E5B9ull;
    h = (h ^ (h >> 29)) + static_cast<std::uint64_t>(z) * 0x94D049BB133111EBull;
    h = (h ^ (h >> 30)) + label * 0xD1342543DE82EF95ull;
    return h ^ (h >> 32);
  }
};

Cell cellOf(const LabelledCloud& cloud, std::size_t i) {
  const Eigen::Vector3d p = cloud.position(i) / kCell_m;
  return {static_cast<std::int64_t>(std::floor(p.x())),
          static_cast<std::int64_t>(std::floor(p.y())),
          static_cast<std::int64_t>(std::floor(p.z())), cloud.points[i].label};
}

/// How many points of each step a cell has.
class Looks {
 public:
  /// Number of the cell, which is made if it is new.
  std::uint32_t numberOf(const Cell& cell) {
    if (2 * cells_.size() >= slots_.size()) grow();
    const std::size_t slot = slotOf(cell);
    if (slots_[slot] == 0) {
      cells_.push_back(cell);
      counts_.push_back({});
      slots_[slot] = static_cast<std::uint32_t>(cells_.size());
    }
    return slots_[slot] - 1;
  }
  void count(std::uint32_t number, float sigma_m) { ++counts_[number][stepOf(sigma_m)]; }

  /// Per cell, what is kept.
  std::vector<float> limits() const {
    std::vector<float> limits;
    for (const auto& counts : counts_) {
      int step = 0;
      for (std::uint32_t seen = counts[0]; seen < kBest && step + 1 < kSteps;)
        seen += counts[++step];
      limits.push_back(step + 1 < kSteps ? kWorse * upperEnd(step) : INFINITY);
    }
    return limits;
  }

 private:
  std::size_t slotOf(const Cell& cell) const {
    const std::size_t mask = slots_.size() - 1;
    std::size_t slot = cell.hash() & mask;
    while (slots_[slot] != 0 && !(cells_[slots_[slot] - 1] == cell)) slot = (slot + 1) & mask;
    return slot;
  }
  void grow() {
    slots_.assign(2 * slots_.size(), 0);
    for (std::size_t i = 0; i < cells_.size(); ++i)
      slots_[slotOf(cells_[i])] = static_cast<std::uint32_t>(i + 1);
  }

  std::vector<std::uint32_t> slots_ =
      std::vector<std::uint32_t>(1024, 0);  ///< 1 + number, 0 = free
  std::vector<Cell> cells_;
  std::vector<std::array<std::uint32_t, kSteps>> counts_;
};

constexpr double kBlockSide = 3;  ///< [voxels]
constexpr std::uint32_t kStoodThere =
    100;  ///< points in a voxel: more than a sensor on the move sees
/// Voxels of a block that are occupied: 9 of a plane, 6 to 9 of scanners and exact cameras, 13 to
/// 19 of stereo cameras (each class counted).
constexpr float kSharp = 10, kScattered = 13;

/// Voxels of a cloud by blocks.
class Blocks {
 public:
  Blocks(const LabelledCloud& voxels, const std::vector<std::uint32_t>& points, double block_m)
      : block_of_(voxels.size()) {
    std::unordered_map<std::uint64_t, std::uint32_t> numbers;
    numbers.reserve(voxels.size() / 4);
    for (std::size_t i = 0; i < voxels.size(); ++i) {
      const auto [it, is_new] = numbers.try_emplace(keyOf(voxels.position(i) / block_m),
                                                    static_cast<std::uint32_t>(occupied_.size()));
      if (is_new) {
        occupied_.push_back(0);
        points_.push_back(0);
      }
      block_of_[i] = it->second;
      ++occupied_[it->second];
      points_[it->second] += std::min(points[i], kStoodThere);
    }
  }

  /// Points around a voxel.
  float around(std::size_t voxel) const { return static_cast<float>(points_[block_of_[voxel]]); }
  /// Occupied voxels in the block of the median voxel.
  float thickness() const { return ofMedian(occupied_); }
  /// Points in the block of the median point.
  float usual() const { return ofMedian(points_); }

 private:
  static std::uint64_t keyOf(const Eigen::Vector3d& p) {
    const auto part = [](double v) {
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(v))) & 0x1FFFFF;
    };
    return part(p.x()) << 42 | part(p.y()) << 21 | part(p.z());
  }

  static float ofMedian(std::vector<std::uint32_t> counts) {
    std::sort(counts.begin(), counts.end());
    const auto all = std::accumulate(counts.begin(), counts.end(), std::size_t{0});
    std::size_t up_to = 0, block = 0;
    while (2 * (up_to += counts[block]) < all) ++block;
    return static_cast<float>(counts[block]);
  }

  std::vector<std::uint32_t> block_of_, occupied_, points_;
};

}  // namespace

float rangeOf(const FrameDigest& frame, std::size_t i) {
  if (frame.sensor == Sensor::cloud) return 0;
  const Eigen::Vector3f sensor =
      (frame.T_odom_sensor.translation() - frame.cloud.origin).cast<float>();
  return (frame.cloud.points[i].getVector3fMap() - sensor).norm();
}

std::size_t appendKnownPoints(const FrameDigest& frame, double max_sigma_m, std::uint32_t view,
                              LabelledCloud& cloud) {
  const Eigen::Vector3f shift = (frame.cloud.origin - cloud.origin).cast<float>();
  const std::size_t before = cloud.points.size();
  for (Point point : frame.cloud.points) {
    if (!(double{point.sigma} <= max_sigma_m)) continue;
    point.getVector3fMap() += shift;
    point.instance = 0;  // numbers of two frames need not agree
    point.view = view;
    cloud.points.push_back(point);
  }
  return cloud.points.size() - before;
}

std::vector<bool> bestLooks(const LabelledCloud& cloud) {
  std::vector<bool> kept(cloud.size(), true);
  if (std::all_of(cloud.points.begin(), cloud.points.end(),
                  [](const Point& p) { return p.sigma <= kGood_m; }))
    return kept;
  Looks looks;
  std::vector<std::uint32_t> numbers(cloud.size(), 0);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    numbers[i] = looks.numberOf(cellOf(cloud, i));
    looks.count(numbers[i], cloud.points[i].sigma);
  }
  const std::vector<float> limits = looks.limits();
  for (std::size_t i = 0; i < cloud.size(); ++i)
    kept[i] = cloud.points[i].sigma <= std::max(kGood_m, limits[numbers[i]]);
  return kept;
}

void keepBestLooks(LabelledCloud& cloud) {
  const std::vector<bool> keep = bestLooks(cloud);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (keep[i]) cloud.points[kept++] = cloud.points[i];
  }
  cloud.points.resize(kept);
}

std::vector<float> trustByDensity(const LabelledCloud& voxels,
                                  const std::vector<std::uint32_t>& points, double voxel_m) {
  std::vector<float> trust(voxels.size(), 1);
  if (voxels.empty()) return trust;
  const Blocks blocks(voxels, points, kBlockSide * voxel_m);
  const float scattered =
      std::clamp((blocks.thickness() - kSharp) / (kScattered - kSharp), 0.f, 1.f);
  if (scattered == 0) return trust;
  const float full = blocks.usual();
  for (std::size_t i = 0; i < trust.size(); ++i)
    trust[i] = std::pow(std::min(1.f, blocks.around(i) / full), 2 * scattered);
  return trust;
}

}  // namespace xview
