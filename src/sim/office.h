// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "sim/render.h"
#include "sim/streets.h"
#include "sim/town.h"
#include "xview/base/labels.h"

namespace xview {

/// Shape of a simulated office floor: blocks of rooms, back to back, with corridors between and
/// around them. The seed decides everything that the fields leave open.
struct OfficeOptions {
  std::uint64_t seed = 1;
  std::uint64_t pattern_seed = 1;  ///< decides how alike rooms are furnished
  double alike = 0;                ///< share of the rooms that are furnished after the pattern

  int blocks_x = 2, blocks_y = 2;  ///< blocks of rooms from west to east, from south to north
  int rooms = 5;                   ///< side by side in a block
  double room_width_m = 4;         ///< along the corridor
  double room_depth_m = 4.6;       ///< away from the corridor
  double corridor_m = 2;           ///< width of the corridors
  double clutter = 1;              ///< factor on the number of objects
};

/// Classes of simulated offices, with ids that no town uses.
LabelSet officeLabels();

/// Where a chair may stand, and which way it looks.
using Seat = ParkingPlace;

struct Door {
  Eigen::Vector2d in_corridor = Eigen::Vector2d::Zero();  ///< on the middle line, before the door
  Eigen::Vector2d in_room = Eigen::Vector2d::Zero();      ///< where there is room to look around
  bool open = false;
};

/// A floor without what moves. World frame: x east, y north, z up, floor at 0.
struct Office {
  OfficeOptions options;
  TriangleMesh mesh;
  StreetNetwork corridors;  ///< junctions on the middle lines
  std::vector<Door> doors;
  std::vector<Seat> seats;
  std::vector<Footprint> floor_space;  ///< of rooms and corridors, for loose objects
  TagSource tags;
};

/// Same options and seed: same floor, on every machine.
Office makeOffice(const OfficeOptions& options);

/// Chairs, boxes, bags and people of one day; another seed is another day.
TriangleMesh makeClutter(const Office& office, std::uint64_t day_seed);

/// Poses on the floor (x forward, y left, z up) of a walk along the corridors and into some of the
/// rooms, to look around there: a pose every `spacing_m` or 15 degrees.
std::vector<Eigen::Isometry3d> planWalk(const Office& office, double length_m, double spacing_m,
                                        bool is_way_back, std::uint64_t seed);

}  // namespace xview
