// SPDX-License-Identifier: BSD-3-Clause
#include "sensor.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace other_worlds {

using Eigen::Isometry3d;

Vector3d Sensor::ray(int u, int v) const {
  if (!scanner)
    return Vector3d((u - (width - 1) / 2.0) / focal, (v - (height - 1) / 2.0) / focal, 1)
        .normalized();
  const double azimuth = (u + 0.5) * 2 * kPi / width - kPi,
               up = (10 - 40.0 * v / (height - 1)) * kPi / 180;
  return {std::cos(azimuth) * std::cos(up), std::sin(azimuth) * std::cos(up), std::sin(up)};
}

bool Sensor::covers(const Vector3d& c, double r, int& u0, int& u1, int& v0, int& v1) const {
  u0 = v0 = 0, u1 = width - 1, v1 = height - 1;
  if (scanner) {
    const double flat = c.head<2>().norm();
    if (flat <= r) return true;
    const double middle = std::atan2(c.y(), c.x()), half = std::asin(r / flat);
    u0 = int(std::floor((middle - half + kPi) / (2 * kPi) * width)) - 1;
    u1 = int(std::ceil((middle + half + kPi) / (2 * kPi) * width)) + 1;
    if (u1 - u0 >= width) u0 = 0, u1 = width - 1;
    return true;
  }
  if (c.z() < -r) return false;
  if (c.z() < r + 0.2) return true;
  const auto span = [&](double at, double middle, int size, int& low, int& high) {
    const double a = (at - r) / (at - r < 0 ? c.z() - r : c.z() + r),
                 b = (at + r) / (at + r < 0 ? c.z() + r : c.z() - r);
    low = std::max(0, int(std::floor(a * focal + middle)));
    high = std::min(size - 1, int(std::ceil(b * focal + middle)));
    return low <= high;
  };
  return span(c.x(), (width - 1) / 2.0, width, u0, u1) &&
         span(c.y(), (height - 1) / 2.0, height, v0, v1);
}

double distanceToGround(const World& world, const Vector3d& from, const Vector3d& along,
                        double reach) {
  if (!world.relief)
    return along.z() < 0 && from.z() < -reach * along.z() ? -from.z() / along.z() : -1;
  const auto isBelow = [&](double t) {
    const Vector3d at = from + t * along;
    return at.z() < world.relief(at.x(), at.y());
  };
  // The first change of sign of the height above ground, then bisection.
  double low = 0, high = 0.5;
  for (; !isBelow(high); high *= 1.06) {
    if (high >= reach) return -1;
    low = high;
  }
  for (int k = 0; k < 30; ++k) {
    const double t = (low + high) / 2;
    (isBelow(t) ? high : low) = t;
  }
  return high;
}

View cast(const World& world, const Sensor& sensor, const Isometry3d& pose, double reach) {
  const size_t n = size_t(sensor.width) * size_t(sensor.height);
  View view{std::vector<double>(n, std::numeric_limits<double>::infinity()),
            std::vector<int>(n, -1)};
  const Vector3d from = pose.translation();
  std::vector<Vector3d> rays(n);
  for (int v = 0; v < sensor.height; ++v) {
    for (int u = 0; u < sensor.width; ++u) {
      const size_t i = size_t(v) * size_t(sensor.width) + size_t(u);
      const Vector3d along = rays[i] = pose.linear() * sensor.ray(u, v);
      const double high = distanceToGround(world, from, along, reach);
      if (high < 0) continue;
      view.range[i] = high;
      view.label[i] = world.ground(from.x() + high * along.x(), from.y() + high * along.y());
    }
  }
  const Isometry3d to_sensor = pose.inverse();
  for (const Thing& thing : world.things) {
    const double radius = thing.half.norm();
    if ((thing.center - from).norm() > reach + radius) continue;
    int u0, u1, v0, v1;
    if (!sensor.covers(to_sensor * thing.center, radius, u0, u1, v0, v1)) continue;
    const Thing::Turn turned(thing);
    for (int v = v0; v <= v1; ++v) {
      for (int column = u0; column <= u1; ++column) {
        const int u = (column + sensor.width) % sensor.width;
        const size_t i = size_t(v) * size_t(sensor.width) + size_t(u);
        const double t = thing.hit(from, rays[i], turned);
        if (t < view.range[i]) view.range[i] = t, view.label[i] = thing.label;
      }
    }
  }
  return view;
}

void mislabel(View& view, const Sensor& sensor, int classes, double share, Random& random) {
  const int patch = sensor.scanner ? 6 : 12;
  for (int v = 0; v < sensor.height; v += patch) {
    for (int u = 0; u < sensor.width; u += patch) {
      if (!random.chance(share)) continue;
      const int other = random.below(classes);
      for (int y = v; y < std::min(v + patch, sensor.height); ++y) {
        for (int x = u; x < std::min(u + patch, sensor.width); ++x) {
          int& label = view.label[size_t(y) * size_t(sensor.width) + size_t(x)];
          if (label >= 0) label = other;
        }
      }
    }
  }
}

}  // namespace other_worlds
