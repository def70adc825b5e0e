// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "xview/sim/lots.h"
#include "xview/sim/site.h"
#include "xview/sim/town_options.h"

namespace xview {

/// A town without its traffic. World frame: x east, y north, z up, metres, origin near the first
/// junction.
struct Town {
  TownOptions options;
  StreetNetwork network;
  StreetField field;
  Relief relief;
  TriangleMesh mesh;
  std::vector<ParkingPlace> parking;
  std::uint16_t last_instance = 0;  ///< traffic counts on from here
};

/// Same options and seed: same town, on every machine.
Town makeTown(const TownOptions& options);

}  // namespace xview
