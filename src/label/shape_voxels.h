// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "xview/types/cells.h"

namespace xview::label {

/// A cell of a lattice in space as a number: 21 bits for each coordinate.
struct LatticeKey {
  std::uint64_t bits = 0;

  static LatticeKey of(std::int64_t x, std::int64_t y, std::int64_t z) {
    constexpr std::int64_t kMiddle = 1 << 20, kMask = (1 << 21) - 1;
    return {static_cast<std::uint64_t>(((x + kMiddle) & kMask) << 42 |
                                       ((y + kMiddle) & kMask) << 21 | ((z + kMiddle) & kMask))};
  }
  LatticeKey at(int dx, int dy, int dz) const {
    const std::int64_t step = (std::int64_t{dx} << 42) + (std::int64_t{dy} << 21) + dz;
    return {bits + static_cast<std::uint64_t>(step)};
  }
  /// The cell of twice the side that holds this one.
  LatticeKey parent() const {
    constexpr std::uint64_t kMask = ((1ULL << 20) - 1) * ((1ULL << 42) + (1ULL << 21) + 1);
    constexpr std::uint64_t kMiddle = (1ULL << 19) * ((1ULL << 42) + (1ULL << 21) + 1);
    return {((bits >> 1) & kMask) + kMiddle};
  }
  bool operator==(const LatticeKey& o) const { return bits == o.bits; }
  std::uint64_t hash() const {
    const std::uint64_t h = (bits ^ (bits >> 32)) * 0x9E3779B97F4A7C15ull;
    return h ^ (h >> 29);
  }
};

/// Sums over points that give their mean and covariance.
struct PointSums {
  double count = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 6, 1> squares = Eigen::Matrix<double, 6, 1>::Zero();  ///< xx xy xz yy yz zz

  void add(const Eigen::Vector3d& p) {
    count += 1;
    sum += p;
    squares[0] += p.x() * p.x(), squares[1] += p.x() * p.y(), squares[2] += p.x() * p.z();
    squares[3] += p.y() * p.y(), squares[4] += p.y() * p.z(), squares[5] += p.z() * p.z();
  }
  void add(const PointSums& other) {
    count += other.count;
    sum += other.sum;
    squares += other.squares;
  }
};

/// How the points around a place are spread: the eigenvalues of their covariance.
struct Spread {
  float linear = 0, planar = 0;  ///< shares of the largest deviation that only one, or two, have
  float normal_z = 0;            ///< of the direction with the least spread, absolute
  float axis_z = 0;              ///< of the direction with the greatest spread, absolute
};
Spread spreadOf(const PointSums& sums);

/// Points in voxels of several sides, each twice the one before.
class ShapeVoxels {
 public:
  static constexpr int kLevels = 3;

  explicit ShapeVoxels(double finest_m) : finest_m_(finest_m) {}

  /// Number of the finest voxel of a point.
  std::size_t add(const Eigen::Vector3d& p);
  /// All points are there.
  void finish();

  std::size_t size() const { return levels_[0].size(); }
  LatticeKey key(std::size_t voxel) const { return levels_[0][voxel].key; }
  const PointSums& points(std::size_t voxel) const { return levels_[0][voxel].sums; }
  std::int32_t find(LatticeKey key) const { return levels_[0].find(key); }  ///< or -1

  /// The sums over the 27 voxels around one at a level.
  struct Neighbourhood {
    LatticeKey key;
    PointSums sums;
    std::optional<Spread> spread;  ///< once somebody has asked for it
    std::int32_t parent = -1;
    bool is_summed = false;
    PointSums around;
  };
  /// Of the voxel at a level that holds this finest one.
  Neighbourhood& around(std::size_t voxel, int level);

 private:
  double finest_m_;
  std::array<CellTable<Neighbourhood>, kLevels> levels_;
};

}  // namespace xview::label
