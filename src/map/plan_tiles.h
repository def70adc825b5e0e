// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "packed_bytes.h"
#include "xview/types/plan_view.h"

namespace xview {

/// What a plan view has in a square of 64 x 64 cells.
struct PlanTile {
  std::int64_t x = 0, y = 0;  ///< floor(cell index / 64)
  std::uint32_t known = 0;    ///< cells that were seen
  std::uint32_t samples = 0;
  Bytes data;
};

/// Tiles sorted by (y, x). Coordinates are rounded to 1 cm; a cell known twice counts once. Throws
/// std::out_of_range on coordinates that are not finite or too far.
std::vector<PlanTile> toTiles(const PlanView& plan);

/// Appends the content of a tile; throws Damage. `plan` has its grid already. Known cells come tile
/// by tile.
void appendTile(const PlanTile& tile, PlanView& plan);

/// Names of the channels in the order of storage; another order is another file.
std::string channelNames();

}  // namespace xview
