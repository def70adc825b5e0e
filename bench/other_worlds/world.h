// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace other_worlds {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPi = 3.14159265358979;

// Random numbers without the distributions of the standard library, which differ between its
// implementations.
struct Random {
  std::mt19937_64 bits;
  double uniform(double low, double high) {
    return low + (high - low) * double(bits() >> 11) * 0x1p-53;
  }
  bool chance(double p) { return uniform(0, 1) < p; }
  double normal() {
    return std::sqrt(-2 * std::log(uniform(1e-12, 1))) * std::cos(uniform(0, 2 * kPi));
  }
  int below(int n) { return int(uniform(0, n)); }
};

enum class Shape { box, cylinder, ellipsoid };

// A solid with a vertical axis: its half sizes are along its own axes, turned by yaw about z.
struct Thing {
  Shape shape;
  Vector3d center, half;
  double yaw;
  int label;

  // Cosine and sine of the yaw, which is the same for many rays.
  struct Turn {
    double c, s;
    explicit Turn(const Thing& thing) : c(std::cos(thing.yaw)), s(std::sin(thing.yaw)) {}
    Vector3d operator()(const Vector3d& v) const {
      return Vector3d(c * v.x() + s * v.y(), c * v.y() - s * v.x(), v.z());
    }
  };

  // The distance along the ray to the surface, or infinity; `from` may be inside.
  double hit(const Vector3d& from, const Vector3d& along, const Turn& turned) const {
    const Vector3d o = turned(from - center), d = turned(along);
    double near = -1e9, far = 1e9;
    const auto slab = [&](int axis) {
      if (std::abs(d[axis]) < 1e-12) {
        if (std::abs(o[axis]) > half[axis]) far = -1e9;
        return;
      }
      const double a = (-half[axis] - o[axis]) / d[axis], b = (half[axis] - o[axis]) / d[axis];
      near = std::max(near, std::min(a, b));
      far = std::min(far, std::max(a, b));
    };
    const auto quadric = [&](const Vector3d& p, const Vector3d& q) {
      const double a = q.squaredNorm(), b = p.dot(q), root = b * b - a * (p.squaredNorm() - 1);
      if (root < 0 || a < 1e-12) {
        if (a >= 1e-12 || p.squaredNorm() > 1) far = -1e9;
        return;
      }
      near = std::max(near, (-b - std::sqrt(root)) / a);
      far = std::min(far, (-b + std::sqrt(root)) / a);
    };
    const Vector3d p = o.cwiseQuotient(half), q = d.cwiseQuotient(half);
    if (shape == Shape::box) {
      for (int axis = 0; axis < 3; ++axis) slab(axis);
    } else if (shape == Shape::cylinder) {
      slab(2);
      quadric({p.x(), p.y(), 0}, {q.x(), q.y(), 0});
    } else {
      quadric(p, q);
    }
    if (near > far || far < 1e-3) return std::numeric_limits<double>::infinity();
    return near > 1e-3 ? near : far;
  }
};

// A place: solids on a height field whose ground has a class everywhere, and a way through it.
struct World {
  std::vector<std::string> classes;
  std::vector<Thing> things;
  std::vector<Vector2d> route;                   // corners of the way that is driven, m
  std::function<double(double, double)> relief;  // height of the ground over x and y; none = flat
  std::function<int(double, double)> ground = [](double, double) { return 0; };
  double step_m = 2, eye_m = 1.6, noise = 0.001, range_m = 60;
  bool roofed = false;

  double height(double x, double y) const { return relief ? relief(x, y) : 0; }
  int named(const std::string& name) {
    const auto found = std::find(classes.begin(), classes.end(), name);
    if (found != classes.end()) return int(found - classes.begin());
    classes.push_back(name);
    return int(classes.size()) - 1;
  }
  void add(Shape shape, const std::string& name, double x, double y, double bottom,
           const Vector3d& size, double yaw = 0) {
    things.push_back(
        {shape, {x, y, height(x, y) + bottom + size.z() / 2}, size / 2, yaw, named(name)});
  }
  void box(const std::string& name, double x, double y, double bottom, Vector3d size,
           double yaw = 0) {
    add(Shape::box, name, x, y, bottom, size, yaw);
  }
  void post(const std::string& name, double x, double y, double bottom, double tall, double thick) {
    add(Shape::cylinder, name, x, y, bottom, {thick, thick, tall});
  }
  void ball(const std::string& name, double x, double y, double bottom, Vector3d size) {
    add(Shape::ellipsoid, name, x, y, bottom, size);
  }
  void tree(Random& random, double x, double y, const std::string& wood,
            const std::string& leaves) {
    const double tall = random.uniform(2, 5), wide = random.uniform(2.5, 5);
    post(wood, x, y, -0.3, tall + 0.8, random.uniform(0.2, 0.5));
    ball(leaves, x, y, tall, {wide, wide * random.uniform(0.8, 1.2), random.uniform(2.5, 5)});
  }
  double distanceToRoute(double x, double y) const {
    double nearest = 1e9;
    for (size_t i = 0; i + 1 < route.size(); ++i) {
      const Vector2d a = route[i], ab = route[i + 1] - a, ap = Vector2d(x, y) - a;
      const double t = std::clamp(ap.dot(ab) / ab.squaredNorm(), 0.0, 1.0);
      nearest = std::min(nearest, (ap - t * ab).norm());
    }
    return nearest;
  }
  // Draws positions evenly from a square about the origin and calls place(x, y) at each whose
  // distance to the route is neither below `nearest` nor above `farthest`.
  template <typename Place>
  void scatter(Random& random, int draws, double half_side, double nearest, double farthest,
               const Place& place) const {
    for (int i = 0; i < draws; ++i) {
      const double x = random.uniform(-half_side, half_side),
                   y = random.uniform(-half_side, half_side), away = distanceToRoute(x, y);
      if (away < nearest || away > farthest) continue;
      place(x, y);
    }
  }
};

}  // namespace other_worlds
