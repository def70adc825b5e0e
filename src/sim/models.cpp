// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "building.h"

namespace xview {
namespace {

constexpr double kFooting = 0.8;  // walls go this deep, so that slopes leave no gap [m]
constexpr double kEaves = 0.4;    // roofs stick out by this [m]
constexpr double kGarageHeight = 2.6;
constexpr double kRoot = 0.3;  // trunks go this deep [m]

void addWalls(TriangleMesh& mesh, const Eigen::Isometry3d& T, const Eigen::Vector2d& size,
              double height, Tag tag) {
  addBox(mesh, moved(T, 0, 0, -kFooting), {size.x(), size.y(), height + kFooting}, tag);
}

/// Two slopes with the ridge along x, closed by gables.
void addGable(TriangleMesh& mesh, const Eigen::Isometry3d& T, const Eigen::Vector2d& size,
              double base, double rise, Tag tag) {
  const double x = size.x() / 2 + kEaves / 2, y = size.y() / 2 + kEaves;
  const auto p = [&](double px, double py, double pz) { return pointAt(T, px, py, pz); };
  const Eigen::Vector3d ridge_a = p(-x, 0, base + rise), ridge_b = p(x, 0, base + rise);
  addQuad(mesh, p(-x, -y, base), p(x, -y, base), ridge_b, ridge_a, tag);
  addQuad(mesh, p(x, y, base), p(-x, y, base), ridge_a, ridge_b, tag);
  addTriangle(mesh, p(-x, -y, base), ridge_a, p(-x, y, base), tag);
  addTriangle(mesh, p(x, -y, base), p(x, y, base), ridge_b, tag);
  addQuad(mesh, p(-x, -y, base), p(-x, y, base), p(x, y, base), p(x, -y, base), tag);
}

void addRoof(TriangleMesh& mesh, const Eigen::Isometry3d& T, const Eigen::Vector2d& size,
             double base, double rise, Roof roof, Tag tag) {
  if (roof == Roof::gable && size.x() >= size.y()) {
    addGable(mesh, T, size, base, rise, tag);
  } else if (roof == Roof::gable) {
    const Eigen::Isometry3d turned = T * Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ());
    addGable(mesh, turned, {size.y(), size.x()}, base, rise, tag);
  } else if (roof == Roof::hip) {
    const double shorter = size.minCoeff();
    const Eigen::Vector2d taper =
        (size - Eigen::Vector2d::Constant(0.95 * shorter)).cwiseQuotient(size);
    addBox(mesh, moved(T, 0, 0, base), {size.x() + 2 * kEaves, size.y() + 2 * kEaves, rise}, tag,
           taper);
  } else {
    addBox(mesh, moved(T, 0, 0, base), {size.x() + kEaves, size.y() + kEaves, 0.4}, tag);
  }
}

void addExtras(TriangleMesh& mesh, const Eigen::Isometry3d& T, const HouseDesign& design, Tag tag) {
  const Eigen::Vector2d& size = design.size;
  if (design.has_chimney) {
    addBox(mesh, moved(T, 0.25 * size.x(), 0.15 * size.y(), design.wall_m),
           {0.7, 0.7, design.roof_m + 0.8}, tag);
  }
  if (design.has_porch) {
    addBox(mesh, moved(T, -0.1 * size.x(), -size.y() / 2 - 0.6, -kFooting),
           {2.2, 1.4, 2.6 + kFooting}, tag);
  }
  if (design.has_dormer && design.roof != Roof::flat) {
    addBox(mesh, moved(T, -0.15 * size.x(), -0.22 * size.y(), design.wall_m),
           {1.8, 0.35 * size.y(), 0.75 * design.roof_m}, tag);
  }
}

/// Seen from above, in the frame of the house.
Footprint wingOf(const HouseDesign& design) {
  const double depth = std::abs(design.wing_depth_m);
  const double away = design.size.y() / 2 + depth / 2;
  return {{design.wing_shift_m, std::copysign(away, design.wing_depth_m)},
          0,
          {0.5 * design.size.x(), depth}};
}

Footprint garageOf(const HouseDesign& design) {
  const Eigen::Vector2d size(3.2, 5.5);
  return {{design.garage_side * (design.size.x() + size.x()) / 2,
           -design.size.y() / 2 + size.y() / 2 + 0.5},
          0,
          size};
}

void addTrunk(TriangleMesh& mesh, const Eigen::Vector3d& base, const TreeDesign& design, Tag tag) {
  const double radius = 0.08 + 0.018 * design.height_m;
  const Eigen::Vector3d top = base + up(design.trunk_m + 0.6);
  addTube(mesh, base - up(kRoot), top, radius, 0.7 * radius, 6, tag);
}

/// Three lumps around the top of the trunk.
void addSpreadingCrown(TriangleMesh& mesh, const Eigen::Vector3d& base, const TreeDesign& design,
                       Random& random, Tag tag) {
  const double r = design.crown_radius_m, rise = (design.height_m - design.trunk_m) / 2;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d shift{random.uniform(-0.5, 0.5) * r, random.uniform(-0.5, 0.5) * r,
                                design.trunk_m + rise * random.uniform(0.7, 1.2)};
    addLumpyEllipsoid(mesh, base + shift, {0.7 * r, 0.7 * r, 0.8 * rise}, 0.15, random, tag);
  }
}

}  // namespace

Eigen::AlignedBox2d HouseDesign::extent() const {
  Eigen::AlignedBox2d box(-size / 2, size / 2);
  const auto include = [&](const Footprint& part) {
    box.extend(Eigen::AlignedBox2d(part.center - part.size / 2, part.center + part.size / 2));
  };
  if (has_wing) include(wingOf(*this));
  if (has_garage) include(garageOf(*this));
  return box;
}

HouseDesign drawHouse(Random& random) {
  HouseDesign design;
  design.size.x() = random.uniform(7.5, 14);
  design.size.y() = random.uniform(7, 11);
  design.wall_m = random.uniform() < 0.35 ? random.uniform(2.6, 3.4) : random.uniform(4.8, 8);
  const double roof = random.uniform();
  design.roof = roof < 0.2 ? Roof::flat : roof < 0.65 ? Roof::gable : Roof::hip;
  design.roof_m = random.uniform(1.8, 4);
  design.has_wing = random.uniform() < 0.4;
  design.wing_shift_m = random.uniform(-0.25, 0.25) * design.size.x();
  design.wing_depth_m = random.uniform(2.5, 5);
  if (random.uniform() < 0.4) design.wing_depth_m = -design.wing_depth_m;
  design.has_garage = random.uniform() < 0.45;
  design.garage_side = random.uniform() < 0.5 ? -1 : 1;
  design.has_chimney = random.uniform() < 0.6;
  design.has_porch = random.uniform() < 0.35;
  design.has_dormer = random.uniform() < 0.3;
  return design;
}

HouseDesign drawHall(Random& random) {
  HouseDesign design = drawHouse(random);
  design.size = {random.uniform(18, 38), random.uniform(11, 17)};
  design.wall_m = 3.4 * random.uniform(2, 5);
  design.roof = Roof::flat;
  design.wing_shift_m = random.uniform(-0.25, 0.25) * design.size.x();
  design.wing_depth_m = std::copysign(random.uniform(5, 11), design.wing_depth_m);
  design.has_garage = design.has_chimney = design.has_dormer = false;
  return design;
}

void addHouse(TriangleMesh& mesh, const Eigen::Isometry3d& T_world_house, const HouseDesign& design,
              Tag tag) {
  addWalls(mesh, T_world_house, design.size, design.wall_m, tag);
  addRoof(mesh, T_world_house, design.size, design.wall_m, design.roof_m, design.roof, tag);
  addExtras(mesh, T_world_house, design, tag);
  if (design.has_wing) {
    const Footprint wing = wingOf(design);
    const Eigen::Isometry3d T_wing = moved(T_world_house, wing.center.x(), wing.center.y(), 0);
    const double height = 0.7 * design.wall_m;
    addWalls(mesh, T_wing, wing.size, height, tag);
    addRoof(mesh, T_wing, wing.size, height, 0.5 * design.roof_m, design.roof, tag);
  }
  if (design.has_garage) {
    const Footprint garage = garageOf(design);
    addWalls(mesh, moved(T_world_house, garage.center.x(), garage.center.y(), 0), garage.size,
             kGarageHeight, tag);
  }
}

TreeDesign drawTree(Random& random) {
  struct Habit {
    TreeShape shape;
    double until;               ///< cumulative share of the trees
    double thinnest, thickest;  ///< crown radius over height
  };
  constexpr Habit kHabits[] = {{TreeShape::round, 0.45, 0.22, 0.35},
                               {TreeShape::columnar, 0.6, 0.1, 0.16},
                               {TreeShape::conifer, 0.75, 0.2, 0.3},
                               {TreeShape::spreading, 1, 0.3, 0.42}};
  const double drawn = random.uniform();
  const Habit* habit = kHabits;
  while (drawn >= habit->until) ++habit;
  TreeDesign design;
  design.shape = habit->shape;
  design.height_m = random.uniform(4, 11);
  design.crown_radius_m = design.height_m * random.uniform(habit->thinnest, habit->thickest);
  design.trunk_m = std::min(design.height_m * random.uniform(0.15, 0.35), 2.8);
  return design;
}

void addTree(TriangleMesh& mesh, const Eigen::Vector3d& base, const TreeDesign& design,
             Random& random, Tag tag) {
  addTrunk(mesh, base, design, tag);
  const double r = design.crown_radius_m, half = (design.height_m - design.trunk_m) / 2;
  const Eigen::Vector3d foot = base + up(design.trunk_m);
  const Eigen::Vector3d center = foot + up(half);
  if (design.shape == TreeShape::conifer) {
    addTube(mesh, foot, base + up(design.height_m), r, 0.05, 9, tag);
  } else if (design.shape == TreeShape::spreading) {
    addSpreadingCrown(mesh, base, design, random, tag);
  } else {
    addLumpyEllipsoid(mesh, center, {r, r, half}, 0.12, random, tag);
  }
}

void addBush(TriangleMesh& mesh, const Eigen::Vector3d& base, double radius_m, Random& random,
             Tag tag) {
  const double height = radius_m * random.uniform(0.6, 1.3);
  addLumpyEllipsoid(mesh, base + up(0.6 * height), {radius_m, radius_m, height}, 0.15, random, tag);
}

void addCar(TriangleMesh& mesh, const Eigen::Isometry3d& T_world_car, Random& random, Tag tag) {
  const bool van = random.uniform() < 0.15;
  const double length = van ? random.uniform(4.8, 5.6) : random.uniform(3.7, 4.8);
  const double width = random.uniform(1.65, 1.85), sill = 0.25;
  const double body = van ? 1.0 : random.uniform(0.5, 0.65), cabin = van ? 0.8 : 0.6;
  const Eigen::Isometry3d T_body = moved(T_world_car, 0, 0, sill);
  addBox(mesh, T_body, {length, width, body}, tag, {0.97, 0.95});
  const Eigen::Isometry3d T_cabin = moved(T_body, van ? -0.2 : -0.3, 0, body);
  addBox(mesh, T_cabin, {(van ? 0.85 : 0.6) * length, 0.93 * width, cabin}, tag, {0.75, 0.85});
  for (const double x : {-0.3, 0.3}) {
    for (const double y : {-0.5, 0.5}) {
      const Eigen::Vector3d hub(x * length, y * (width - 0.2), 0.3);
      addTube(mesh, T_world_car * (hub - Eigen::Vector3d(0, 0.1, 0)),
              T_world_car * (hub + Eigen::Vector3d(0, 0.1, 0)), 0.3, 0.3, 8, tag);
    }
  }
}

void addPerson(TriangleMesh& mesh, const Eigen::Isometry3d& T, Random& random, Tag tag) {
  const double height = random.uniform(1.5, 1.9);
  for (const double y : {-0.1, 0.1}) {
    addTube(mesh, pointAt(T, 2 * y, y, 0), pointAt(T, 0, y, 0.48 * height), 0.08, 0.1, 5, tag);
  }
  addTube(mesh, T * up(0.46 * height), T * up(0.84 * height), 0.17, 0.22, 7, tag);
  addLumpyEllipsoid(mesh, T * up(0.92 * height), {0.11, 0.11, 0.14}, 0, random, tag);
}

void addBicycle(TriangleMesh& mesh, const Eigen::Isometry3d& T, Tag tag) {
  const auto p = [&](double x, double z) { return pointAt(T, x, 0, z); };
  for (const double x : {-0.5, 0.5}) {
    addTube(mesh, pointAt(T, x, -0.02, 0.33), pointAt(T, x, 0.02, 0.33), 0.33, 0.33, 10, tag);
  }
  addTube(mesh, p(-0.5, 0.33), p(-0.15, 0.9), 0.03, 0.03, 4, tag);
  addTube(mesh, p(-0.15, 0.8), p(0.4, 0.8), 0.03, 0.03, 4, tag);
  addTube(mesh, p(0.5, 0.33), p(0.38, 1.0), 0.03, 0.03, 4, tag);
  addTube(mesh, pointAt(T, 0.38, -0.28, 1.0), pointAt(T, 0.38, 0.28, 1.0), 0.03, 0.03, 4, tag);
}

}  // namespace xview
