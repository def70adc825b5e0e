// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "xview/types/option_field.h"

namespace xview {

/// Shape of a simulated town. The seed decides everything that the fields leave open.
struct TownOptions {
  std::uint64_t seed = 1;  ///< set by whoever makes the town; not a field of its own
  int blocks_x = 4;
  int blocks_y = 4;
  double street_spacing_m = 75;
  double irregularity = 0.6;
  double relief_m = 2.5;
  double house_density = 0.85;
  double row_share = 0.25;
  double tree_density = 1;
  double car_density = 0.25;
};

template <class Visitor>
void visit(TownOptions& o, Visitor&& field) {
  field("blocks_x", o.blocks_x, Range{1, 16}, "blocks of houses from west to east");
  field("blocks_y", o.blocks_y, Range{1, 16}, "blocks of houses from south to north");
  field("street_spacing_m", o.street_spacing_m, Range{50, 200}, "mean distance of crossings [m]");
  field("irregularity", o.irregularity, Range{0, 1},
        "0 = straight grid of streets, 1 = crooked streets, missing and slanting ones");
  field("relief_m", o.relief_m, Range{0, 5}, "hills rise and fall by up to this [m]");
  field("house_density", o.house_density, Range{0, 1}, "share of the lots with a house");
  field("row_share", o.row_share, Range{0, 1},
        "share of the street sides whose houses are all alike, at equal distances");
  field("tree_density", o.tree_density, Range{0, 4}, "factor on the number of trees");
  field("car_density", o.car_density, Range{0, 1}, "share of the parking places taken");
}

}  // namespace xview
