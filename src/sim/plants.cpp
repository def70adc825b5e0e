// SPDX-License-Identifier: BSD-3-Clause
#include "xview/sim/plants.h"

#include <algorithm>

namespace xview {
namespace {

constexpr double kRoot = 0.3;  // trunks go this deep [m]

void addTrunk(TriangleMesh& mesh, const Eigen::Vector3d& base, const TreeDesign& design, Tag tag) {
  const double radius = 0.08 + 0.018 * design.height_m;
  const Eigen::Vector3d top = base + Eigen::Vector3d(0, 0, design.trunk_m + 0.6);
  addTube(mesh, base - Eigen::Vector3d(0, 0, kRoot), top, radius, 0.7 * radius, 6, tag);
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

TreeDesign drawTree(Random& random) {
  TreeDesign design;
  const double shape = random.uniform();
  design.height_m = random.uniform(4, 11);
  if (shape < 0.45) {
    design.shape = TreeShape::round;
    design.crown_radius_m = design.height_m * random.uniform(0.22, 0.35);
  } else if (shape < 0.6) {
    design.shape = TreeShape::columnar;
    design.crown_radius_m = design.height_m * random.uniform(0.1, 0.16);
  } else if (shape < 0.75) {
    design.shape = TreeShape::conifer;
    design.crown_radius_m = design.height_m * random.uniform(0.2, 0.3);
  } else {
    design.shape = TreeShape::spreading;
    design.crown_radius_m = design.height_m * random.uniform(0.3, 0.42);
  }
  design.trunk_m = std::min(design.height_m * random.uniform(0.15, 0.35), 2.8);
  return design;
}

void addTree(TriangleMesh& mesh, const Eigen::Vector3d& base, const TreeDesign& design,
             Random& random, Tag tag) {
  addTrunk(mesh, base, design, tag);
  const double r = design.crown_radius_m, half = (design.height_m - design.trunk_m) / 2;
  const Eigen::Vector3d foot = base + Eigen::Vector3d(0, 0, design.trunk_m);
  const Eigen::Vector3d center = foot + Eigen::Vector3d(0, 0, half);
  switch (design.shape) {
    case TreeShape::round:
    case TreeShape::columnar:
      addLumpyEllipsoid(mesh, center, {r, r, half}, 0.12, random, tag);
      break;
    case TreeShape::conifer:
      addTube(mesh, foot, base + Eigen::Vector3d(0, 0, design.height_m), r, 0.05, 9, tag);
      break;
    case TreeShape::spreading:
      addSpreadingCrown(mesh, base, design, random, tag);
      break;
  }
}

void addBush(TriangleMesh& mesh, const Eigen::Vector3d& base, double radius_m, Random& random,
             Tag tag) {
  const double height = radius_m * random.uniform(0.6, 1.3);
  addLumpyEllipsoid(mesh, base + Eigen::Vector3d(0, 0, 0.6 * height), {radius_m, radius_m, height},
                    0.15, random, tag);
}

}  // namespace xview
