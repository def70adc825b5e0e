// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "graph/cell_index.h"
#include "graph/plan_ground.h"
#include "graph/plan_voxels.h"
#include "xview/graph/plan_view.h"

namespace xview {

constexpr std::size_t kKinds = static_cast<std::size_t>(Kind::none);

/// What stands in a cell, per kind of upright class.
struct UprightCell {
  std::array<float, kKinds> votes{};       ///< above min_height_m
  std::array<float, kKinds> sum_x{}, sum_y{};
  std::array<float, kKinds> low{}, high{};  ///< votes at 0.3–2 m and above 2.5 m
  std::array<float, kKinds> top{};          ///< greatest height above ground [m]
  std::array<float, kKinds> bottom{};       ///< least height above ground [m]
  std::array<float, 3> near_votes{};        ///< of pole, sign, light, measured nearby
  float obstacle_low = 0, obstacle_high = 0;

  float total() const;
  float of(Kind kind) const { return votes[static_cast<std::size_t>(kind)]; }
  float lowOf(Kind kind) const { return low[static_cast<std::size_t>(kind)]; }
  float highOf(Kind kind) const { return high[static_cast<std::size_t>(kind)]; }
  bool holds(Kind kind, double min_votes, double min_share) const;
  PlanSample centre(Kind kind) const;
};

/// What lies in a cell.
struct FloorCell {
  std::array<float, 4> votes{};  ///< road, sidewalk, terrain, lane marking
  float height = 0;              ///< of the ground [m]
  float total = 0;               ///< all votes of the cell, upright ones too
  float ground() const { return votes[0] + votes[1] + votes[2] + votes[3]; }
};

/// All votes of a view sorted into cells. `upright[i]` is the number of the UprightCell of cell i, or -1.
struct PlanCells {
  CellIndex index;
  std::vector<FloorCell> floor;
  std::vector<std::int32_t> upright_of;
  std::vector<UprightCell> upright;

  const UprightCell* uprightAt(std::int32_t x, std::int32_t y) const {
    const std::int32_t i = index.find(x, y);
    return i < 0 || upright_of[i] < 0 ? nullptr : &upright[upright_of[i]];
  }
};

PlanCells sortIntoCells(const std::vector<PlanVoxel>& voxels, const GroundSurface& ground, const GroundRule& rule,
                        const PlanOptions& options);

}  // namespace xview
