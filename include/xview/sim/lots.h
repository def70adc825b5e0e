// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "xview/sim/site.h"
#include "xview/sim/town_options.h"

namespace xview {

/// Where a car may stand.
struct ParkingPlace {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  double yaw = 0;
};

/// Houses with their garages, fences, hedges and gardens on both sides of all streets, and what
/// grows and stands in the middle of the blocks. Returns the parking places on the driveways.
std::vector<ParkingPlace> addLots(Site& site, const StreetNetwork& network,
                                  const TownOptions& options);

/// Trees in a row on one side of some of the streets.
void addStreetTrees(Site& site, const StreetNetwork& network, const TownOptions& options);

/// Trees, bushes and sheds anywhere off the streets up to `margin_m` outside the town.
void addWilderness(Site& site, const TownOptions& options, double margin_m);

}  // namespace xview
