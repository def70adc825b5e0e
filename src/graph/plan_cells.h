// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "graph/cell_index.h"
#include "graph/plan_ground.h"
#include "graph/plan_voxels.h"
#include "xview/graph/plan_view.h"

namespace xview {

/// What stands in a cell, of one upright class, higher than min_height_m.
struct Standing {
  Kind kind = Kind::none;
  float votes = 0;
  float near_votes = 0;  ///< of these, measured near enough for thin objects
  float own_votes = 0;   ///< pole-like: of these, up to 4.5 m, where it outvotes all other classes
  float clear_votes =
      0;  ///< pole-like: near votes at levels where no other of the three has twice as many
  float sum_x = 0, sum_y = 0;  ///< of the positions times their votes
  float low = 0, high = 0;     ///< votes at 0.3–2 m and above 2.5 m
  float top = 0, bottom = 0;   ///< greatest and least height above ground [m]
  std::uint32_t levels = 0;    ///< bit i: something near at i to i + 1 times kLevel_m above ground
};
constexpr float kLevel_m = 0.5f;

/// Of anything that stands in a cell what was measured near enough for thin objects.
struct Column {
  float low = 0, high = 0;  ///< votes at 0.5–2 m and 2–4.5 m
  float x = 0, y = 0;       ///< sums of the positions times their votes
  float votes() const { return low + high; }
};

/// Of ground classes in a cell what is above the ground, where no ground is: labels of things too
/// thin for the image that took those of the ground behind them.
struct Strays {
  float votes = 0, x = 0, y = 0;  ///< sums, as of columns
  std::uint32_t levels = 0;       ///< as in Standing
};

/// All that stands in a cell.
struct UprightCell {
  const Standing* first = nullptr;  ///< its kinds, at most one each: [first, last)
  const Standing* last = nullptr;
  float obstacle_low = 0, obstacle_high = 0;  ///< votes of anything at 0.4–2 m and above 2.5 m
  Column column;
  Strays strays;

  const Standing* find(Kind kind) const;  ///< null if there is none
  float of(Kind kind) const;              ///< votes; the others likewise 0 if there is none
  float nearOf(Kind kind) const;
  float ownOf(Kind kind) const;
  float clearOf(Kind kind) const;
  float lowOf(Kind kind) const;
  float highOf(Kind kind) const;
  float ofThingsBesidePosts() const;  ///< votes of buildings, fences, vegetation and vehicles
  bool holds(Kind kind, double min_votes, double min_share) const;
};

/// What lies in a cell.
struct FloorCell {
  std::array<float, 4> votes{};  ///< road, sidewalk, terrain, lane marking
  float height = 0;              ///< of the ground [m]
  float total = 0;               ///< all votes of the cell, upright ones too
  float ground() const { return votes[0] + votes[1] + votes[2] + votes[3]; }
};

/// All votes of a view sorted into cells. `upright_of[i]` is the number of the UprightCell of cell
/// i, or -1.
struct PlanCells {
  PlanCells() = default;
  PlanCells(PlanCells&&) = default;  // not copied: cells point into `standing`

  CellIndex index;
  std::vector<FloorCell> floor;
  std::vector<std::int32_t> upright_of;
  std::vector<UprightCell> upright;
  std::vector<Standing> standing;

  const UprightCell* uprightOf(std::size_t cell) const {
    return upright_of[cell] < 0 ? nullptr : &upright[upright_of[cell]];
  }
  const UprightCell* uprightAt(std::int32_t x, std::int32_t y) const {
    const std::int32_t i = index.find(x, y);
    return i < 0 ? nullptr : uprightOf(i);
  }
  /// Calls visit(cell, where) for what stands in the cells up to `reach` away, row by row.
  template <class Visit>
  void forUprightAround(CellIndex::Cell c, int reach, Visit&& visit) const {
    for (int dy = -reach; dy <= reach; ++dy) {
      for (int dx = -reach; dx <= reach; ++dx) {
        const CellIndex::Cell where{c.x + dx, c.y + dy};
        if (const UprightCell* cell = uprightAt(where.x, where.y)) visit(*cell, where);
      }
    }
  }
};

PlanCells sortIntoCells(const ChunkedVector<PlanVoxel>& voxels, const GroundSurface& ground,
                        const GroundRule& rule, const PlanOptions& options);

}  // namespace xview
