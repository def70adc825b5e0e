// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "world.h"

namespace other_worlds {

// A camera, or a scanner whose columns go once around. The frame of a camera has z forward, x right
// and y down; that of a scanner x forward, y left and z up.
struct Sensor {
  bool scanner;
  int width, height;
  double focal;  // of a camera, in pixels

  // The direction in which column u of row v looks, in the frame of the sensor.
  Vector3d ray(int u, int v) const;
  // Columns and rows that a ball may cover; columns of a scanner may run past its seam.
  bool covers(const Vector3d& c, double r, int& u0, int& u1, int& v0, int& v1) const;
};

struct View {
  std::vector<double> range;  // m along each ray, infinity where nothing is
  std::vector<int> label;
};

// Along a ray, negative if that is beyond reach.
double distanceToGround(const World& world, const Vector3d& from, const Vector3d& along,
                        double reach);

// What the sensor sees of the world from a pose, without solids that are wholly beyond `reach`.
View cast(const World& world, const Sensor& sensor, const Eigen::Isometry3d& pose, double reach);

// Gives some patches of an image another class, as a network would.
void mislabel(View& view, const Sensor& sensor, int classes, double share, Random& random);

}  // namespace other_worlds
