// SPDX-License-Identifier: BSD-3-Clause
#include "xview/sim/houses.h"

#include <cmath>

namespace xview {
namespace {

constexpr double kFooting = 0.8;  // walls go this deep, so that slopes leave no gap [m]
constexpr double kEaves = 0.4;    // roofs stick out by this [m]
constexpr Eigen::Index kAlong = 0, kAway = 1;
const Eigen::Vector2d kGarageSize(3.2, 5.5);
constexpr double kGarageHeight = 2.6;

Eigen::Isometry3d moved(const Eigen::Isometry3d& T, double x, double y, double z) {
  return T * Eigen::Translation3d(x, y, z);
}

void addWalls(TriangleMesh& mesh, const Eigen::Isometry3d& T, const Eigen::Vector2d& size,
              double height, Tag tag) {
  addBox(mesh, moved(T, 0, 0, -kFooting), {size.x(), size.y(), height + kFooting}, tag);
}

/// Two slopes with the ridge along x, closed by gables.
void addGable(TriangleMesh& mesh, const Eigen::Isometry3d& T, const Eigen::Vector2d& size,
              double base, double rise, Tag tag) {
  const double x = size.x() / 2 + kEaves / 2, y = size.y() / 2 + kEaves;
  const auto p = [&](double px, double py, double pz) { return T * Eigen::Vector3d(px, py, pz); };
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
    addTaperedBox(mesh, moved(T, 0, 0, base), {size.x() + 2 * kEaves, size.y() + 2 * kEaves, rise},
                  taper, tag);
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

Eigen::Vector2d wingSize(const HouseDesign& design) {
  return {0.5 * design.size.x(), std::abs(design.wing_depth_m)};
}

Eigen::Vector2d wingCenter(const HouseDesign& design) {
  const double away = (design.size.y() / 2 + std::abs(design.wing_depth_m) / 2);
  return {design.wing_shift_m, std::copysign(away, design.wing_depth_m)};
}

Eigen::Vector2d garageCenter(const HouseDesign& design) {
  return {design.garage_side * (design.size.x() + kGarageSize.x()) / 2,
          -design.size.y() / 2 + kGarageSize.y() / 2 + 0.5};
}

void extend(Eigen::AlignedBox2d& box, const Eigen::Vector2d& center, const Eigen::Vector2d& size) {
  box.extend(Eigen::AlignedBox2d(center - size / 2, center + size / 2));
}

}  // namespace

Eigen::AlignedBox2d HouseDesign::extent() const {
  Eigen::AlignedBox2d box;
  extend(box, Eigen::Vector2d::Zero(), size);
  if (has_wing) extend(box, wingCenter(*this), wingSize(*this));
  if (has_garage) extend(box, garageCenter(*this), kGarageSize);
  return box;
}

HouseDesign drawHouse(Random& random) {
  HouseDesign design;
  design.size[kAlong] = random.uniform(7.5, 14);
  design.size[kAway] = random.uniform(7, 11);
  design.wall_m = random.uniform() < 0.35 ? random.uniform(2.6, 3.4) : random.uniform(4.8, 8);
  const double roof = random.uniform();
  design.roof = roof < 0.2 ? Roof::flat : roof < 0.65 ? Roof::gable : Roof::hip;
  design.roof_m = random.uniform(1.8, 4);
  design.has_wing = random.uniform() < 0.4;
  design.wing_shift_m = random.uniform(-0.25, 0.25) * design.size[kAlong];
  design.wing_depth_m = random.uniform(2.5, 5);
  if (random.uniform() < 0.4) design.wing_depth_m = -design.wing_depth_m;
  design.has_garage = random.uniform() < 0.45;
  design.garage_side = random.uniform() < 0.5 ? -1 : 1;
  design.has_chimney = random.uniform() < 0.6;
  design.has_porch = random.uniform() < 0.35;
  design.has_dormer = random.uniform() < 0.3;
  return design;
}

void addHouse(TriangleMesh& mesh, const Eigen::Isometry3d& T_world_house, const HouseDesign& design,
              Tag tag) {
  addWalls(mesh, T_world_house, design.size, design.wall_m, tag);
  addRoof(mesh, T_world_house, design.size, design.wall_m, design.roof_m, design.roof, tag);
  addExtras(mesh, T_world_house, design, tag);
  if (design.has_wing) {
    const Eigen::Vector2d size = wingSize(design), center = wingCenter(design);
    const Eigen::Isometry3d T_wing = moved(T_world_house, center.x(), center.y(), 0);
    const double height = 0.7 * design.wall_m;
    addWalls(mesh, T_wing, size, height, tag);
    addRoof(mesh, T_wing, size, height, 0.5 * design.roof_m, design.roof, tag);
  }
  if (design.has_garage) {
    const Eigen::Vector2d center = garageCenter(design);
    const Eigen::Isometry3d T_garage = moved(T_world_house, center.x(), center.y(), 0);
    addWalls(mesh, T_garage, kGarageSize, kGarageHeight, tag);
  }
}

}  // namespace xview
