// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "packed_bytes.h"
#include "xview/types/labelled_cloud.h"

namespace xview {

/// The points of a cloud in a cube of 64 m.
struct CloudTile {
  std::int64_t x = 0, y = 0, z = 0;  ///< floor((p - origin) / 64 m)
  std::uint32_t points = 0;
  Bytes data;
};

/// Tiles sorted by (z, y, x). Coordinates are rounded to 1 cm, points that are not finite are
/// dropped. Throws std::out_of_range on points too far from the origin.
std::vector<CloudTile> toTiles(const LabelledCloud& cloud);

/// Appends points with their instances, sorted by label, instance, position; throws Damage.
void appendTile(const CloudTile& tile, LabelledCloud& cloud);

}  // namespace xview
