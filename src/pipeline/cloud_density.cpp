// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/cloud_density.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <unordered_map>

namespace xview {
namespace {

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
