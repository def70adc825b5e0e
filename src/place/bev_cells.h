// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "base/cells.h"
#include "xview/base/bev_grid.h"
#include "xview/base/labels.h"

namespace xview {

// From weights to the cells of a BEV grid: weights are summed in voxels, voxels tell the height of
// the ground, and above it they are sorted into cells.

constexpr float kMinWeight = 1;    ///< least sum of weights for a cell to tell a class
constexpr double kMinShare = 0.5;  ///< and if the class holds this share of the cell

/// A voxel and a kind as a number: 21 bits for each of x and y (two million voxels), 18 for z, 4
/// for the kind. Larger coordinates wrap around.
struct VoxelKey {
  std::uint64_t bits = 0;

  bool operator==(const VoxelKey& o) const { return bits == o.bits; }
  std::uint64_t hash() const {
    const std::uint64_t h = (bits ^ (bits >> 32)) * 0x9E3779B97F4A7C15ull;
    return h ^ (h >> 29);
  }
  Kind kind() const { return static_cast<Kind>(bits & 0xF); }
};
/// The voxel of side kBevVoxel_m of a point relative to the origin of the grid.
VoxelKey voxelOf(const Eigen::Vector3d& p, Kind kind);

/// Votes of one kind in one voxel.
struct BevVoxel {
  VoxelKey key;
  float x = 0, y = 0, z = 0;  ///< weighted mean, relative to the origin of the grid [m]
  float weight_sum = 0;
  float near_weight = 0;  ///< of these, measured near enough for thin objects
  Kind kind() const { return key.kind(); }
};
using BevVoxels = ChunkedVector<BevVoxel>;

/// How the ground is drawn from points that are wrong now and then: labels under trees, stereo
/// noise from the air.
struct GroundRule {
  double quantile;  ///< of the heights in a 2 m cell: low near the ground, the median from the air
  double gate_m;    ///< half thickness of the layer that counts as ground
};
GroundRule groundRule(bool aerial);

/// Height of the ground on a 2 m lattice.
HeightLattice groundSurface(const BevVoxels& voxels, const GroundRule& rule);

/// What stands in a cell, of one upright class, higher than spilt labels.
struct ClassColumn {
  Kind kind = Kind::none;
  float weight_sum = 0;
  float near_weight = 0;       ///< of these, measured near enough for thin objects
  float sum_x = 0, sum_y = 0;  ///< of the positions times their weights
  float low = 0, high = 0;     ///< weights at 0.3–2 m and above 2.5 m
  float top = 0, bottom = 0;   ///< greatest and least height above ground [m]
};

/// All that stands in a cell.
struct ObstacleCell {
  const ClassColumn* first = nullptr;  ///< its kinds, at most one each: [first, last)
  const ClassColumn* last = nullptr;
  float obstacle_low = 0, obstacle_high = 0;  ///< weights of anything at 0.4–2 m and above 2.5 m

  const ClassColumn& of(Kind kind) const;  ///< without weights if there is none
  float ofObjectsBesidePosts() const;  ///< weights of buildings, fences, vegetation and vehicles
  bool holds(Kind kind, double min_share) const;
};

/// What lies in a cell.
struct FloorCell {
  std::array<float, 4> weight_sum{};  ///< road, sidewalk, terrain, lane marking
  float height = 0;                   ///< of the ground [m]
  float total = 0;                    ///< all weights of the cell, upright ones too
  float ground() const { return weight_sum[0] + weight_sum[1] + weight_sum[2] + weight_sum[3]; }
};

/// All weights of a view sorted into cells of kBevCell_m. `obstacle_of[i]` is the number of the
/// ObstacleCell of cell i, or -1.
struct BevCells {
  BevCells() = default;
  BevCells(BevCells&&) = default;  // not copied: obstacles point into `columns`

  CellIndex index;
  std::vector<FloorCell> floor;
  std::vector<std::int32_t> obstacle_of;
  std::vector<ObstacleCell> obstacles;
  std::vector<ClassColumn> columns;

  std::size_t size() const { return floor.size(); }
  PlaneCell cell(std::size_t i) const { return index.cells()[i]; }
  const ObstacleCell* obstacleCellOf(std::size_t cell) const {
    return obstacle_of[cell] < 0 ? nullptr : &obstacles[obstacle_of[cell]];
  }
  BevSample middleOf(std::size_t cell) const;  ///< on the ground
};

BevCells sortIntoCells(const BevVoxels& voxels, const HeightLattice& ground,
                       const GroundRule& rule);

/// A value per cell of a view, 0 where nothing stands. The cells must outlive it.
class ValueGrid {
 public:
  ValueGrid(const BevCells& cells, const std::function<float(const ObstacleCell&)>& value);
  /// Sum over the square of half size `reach` around each cell with a value; 0 elsewhere.
  ValueGrid boxSum(int reach) const;
  float at(PlaneCell cell) const;
  float operator[](std::size_t i) const { return values_[i]; }
  /// Largest within `reach` cells; of equal ones the first in (y, x) order.
  bool isMaximum(std::size_t i, int reach) const;

 private:
  const BevCells* cells_;
  std::vector<float> values_;
};

/// Poles, signs and lights as density peaks, because clusters of them smear along the ray with
/// noise, and what is pole-like by its shape. They are where they stand on the ground.
void findPosts(const BevCells& cells, BevGrid& view);

/// Vehicles, trunks and other objects as clusters of cells, trees as maxima of the canopy.
void findBevObjects(const BevCells& cells, BevGrid& view);

}  // namespace xview
