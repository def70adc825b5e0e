// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "sim/town.h"

namespace xview {

// What a town is built of: single things, drawn at random and put into a mesh (models.cpp), and the
// steps that fill a town with them (ground.cpp, lots.cpp).

inline Eigen::Vector3d up(double z) { return {0, 0, z}; }
/// A point of the frame of a thing, and that frame moved there.
inline Eigen::Vector3d pointAt(const Eigen::Isometry3d& T, double x, double y, double z) {
  return T * Eigen::Vector3d(x, y, z);
}
inline Eigen::Isometry3d moved(const Eigen::Isometry3d& T, double x, double y, double z) {
  return T * Eigen::Translation3d(x, y, z);
}

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
/// A building of a campus: long, of several storeys, with a flat roof.
HouseDesign drawHall(Random& random);

/// T_world_house: on the ground at the centre of the main body, y away from the street.
void addHouse(TriangleMesh& mesh, const Eigen::Isometry3d& T_world_house, const HouseDesign& design,
              Tag tag);

enum class TreeShape { round, columnar, conifer, spreading };

struct TreeDesign {
  TreeShape shape = TreeShape::round;
  double height_m = 7;
  double crown_radius_m = 2;
  double trunk_m = 2;  ///< height of the lowest leaves
};

TreeDesign drawTree(Random& random);

/// Trunk and crown, standing at `base`.
void addTree(TriangleMesh& mesh, const Eigen::Vector3d& base, const TreeDesign& design,
             Random& random, Tag tag);
void addBush(TriangleMesh& mesh, const Eigen::Vector3d& base, double radius_m, Random& random,
             Tag tag);

/// T_world_thing: on the ground, x ahead.
void addCar(TriangleMesh& mesh, const Eigen::Isometry3d& T_world_car, Random& random, Tag tag);
void addPerson(TriangleMesh& mesh, const Eigen::Isometry3d& T_world_person, Random& random,
               Tag tag);
void addBicycle(TriangleMesh& mesh, const Eigen::Isometry3d& T_world_bicycle, Tag tag);

/// Road, sidewalk, terrain and curbs up to `margin_m` beyond the streets, cut along the edges of
/// the streets.
void addGround(Town& town, double margin_m);

/// Dashed and solid lines along the streets and zebra crossings, just above the road.
void addLaneMarkings(Town& town);

/// Houses with their garages, fences, hedges and gardens on both sides of all streets, and parking
/// places on the driveways.
void addLots(Town& town);

/// Trees in a row on one side of some of the streets.
void addStreetTrees(Town& town);

/// Trees and sheds anywhere off the streets up to `margin_m` outside the town.
void addWilderness(Town& town, double margin_m);

}  // namespace xview
