// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "xview/sim/mesh.h"

namespace xview {

enum class Roof { flat, gable, hip };

struct HouseDesign {
  Eigen::Vector2d size{10, 8};  ///< along the street, away from it [m]
  double wall_m = 5;
  double roof_m = 3;
  Roof roof = Roof::gable;
  bool has_wing = false;    ///< an L: a second, lower body behind or in front
  double wing_shift_m = 0;  ///< along the street
  double wing_depth_m = 4;  ///< > 0: behind, < 0: towards the street
  bool has_garage = false;
  double garage_side = 1;  ///< +1 or -1 along the street
  bool has_chimney = true;
  bool has_porch = false;
  bool has_dormer = false;

  /// Size with wing and garage, and how far its centre lies off that of the main body.
  Eigen::AlignedBox2d extent() const;
};

HouseDesign drawHouse(Random& random);

/// T_world_house: on the ground at the centre of the main body, y away from the street.
void addHouse(TriangleMesh& mesh, const Eigen::Isometry3d& T_world_house, const HouseDesign& design,
              Tag tag);

}  // namespace xview
