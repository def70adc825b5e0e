// SPDX-License-Identifier: BSD-3-Clause
// Worlds of another make than those of `xview simulate`, with which they share no code: boxes,
// cylinders and ellipsoids on a height field, cast into depth and label images and scans. Their
// classes have names of their own and no roles. `bench/verdict_table.py` localizes in them.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/imgcodecs.hpp>

namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPi = 3.14159265358979;

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

// A solid with a vertical axis: half sizes along its own axes, turned by yaw about z.
struct Thing {
  Shape shape;
  Vector3d center, half;
  double yaw;
  int label;

  // Distance along the ray to the surface, or infinity; `from` may be inside.
  double hit(const Vector3d& from, const Vector3d& along) const {
    const double c = std::cos(yaw), s = std::sin(yaw);
    const auto turned = [&](const Vector3d& v) {
      return Vector3d(c * v.x() + s * v.y(), c * v.y() - s * v.x(), v.z());
    };
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

struct World {
  std::vector<std::string> classes;
  std::vector<Thing> things;
  std::vector<Vector2d> route;  // corners of the way that is driven, m
  std::function<double(double, double)> height = [](double, double) { return 0.0; };
  std::function<int(double, double)> ground = [](double, double) { return 0; };
  double step_m = 2, eye_m = 1.6, noise = 0.001, range_m = 60;
  bool roofed = false;

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
};

std::vector<Vector2d> loop(Random& random, double radius, double rough, int corners) {
  std::vector<Vector2d> route;
  std::vector<double> wave(6);
  for (double& w : wave) w = random.uniform(-rough, rough);
  for (int i = 0; i <= corners; ++i) {
    const double a = 2 * kPi * i / corners;
    double r = radius;
    for (int k = 0; k < 3; ++k)
      r += wave[size_t(k)] * std::cos((k + 2) * a) + wave[size_t(k + 3)] * std::sin((k + 2) * a);
    route.emplace_back(r * std::cos(a), r * std::sin(a));
  }
  return route;
}

World forest(Random& random) {
  World w;
  const double p = random.uniform(0, 6), q = random.uniform(0, 6);
  w.height = [=](double x, double y) {
    return 3 * std::sin(x / 37 + p) + 2.5 * std::sin(y / 29 + q) + 0.4 * std::sin((x + y) / 7);
  };
  w.route = loop(random, 65, 6, 72);
  const int track = w.named("gravel track"), soil = w.named("soil");
  w.ground = [=](double x, double y) { return w.distanceToRoute(x, y) < 1.8 ? track : soil; };
  for (int i = 0; i < 1700; ++i) {
    const double x = random.uniform(-115, 115), y = random.uniform(-115, 115),
                 away = w.distanceToRoute(x, y);
    if (away < 2.6 || away > 45) continue;
    const double tall = random.uniform(5, 11);
    w.post("trunk", x, y, -0.5, tall + 1, random.uniform(0.25, 0.7));
    const double wide = random.uniform(3, 6);
    w.ball("crown", x, y, tall - 2, {wide, wide, random.uniform(4, 7)});
  }
  for (int i = 0; i < 260; ++i) {
    const double x = random.uniform(-110, 110), y = random.uniform(-110, 110);
    if (w.distanceToRoute(x, y) < 2.2) continue;
    const double s = random.uniform(0.5, 1.8);
    w.ball(random.chance(0.6) ? "shrub" : "boulder", x, y, -0.2,
           {s, s * random.uniform(0.7, 1.3), s * 0.9});
  }
  return w;
}

World oldTown(Random& random) {
  World w;
  const int stones = w.named("cobbles");
  w.ground = [=](double, double) { return stones; };
  std::vector<double> xs, ys;  // middles of the lanes
  for (double at = -70; at < 75; at += random.uniform(24, 36)) xs.push_back(at);
  for (double at = -60; at < 65; at += random.uniform(22, 34)) ys.push_back(at);
  const double lane = 5;
  for (size_t i = 0; i + 1 < xs.size(); ++i) {
    for (size_t j = 0; j + 1 < ys.size(); ++j) {
      const double x0 = xs[i] + lane / 2, x1 = xs[i + 1] - lane / 2, y0 = ys[j] + lane / 2,
                   y1 = ys[j + 1] - lane / 2;
      for (int side = 0; side < 4; ++side) {
        const bool along_x = side < 2;
        const double from = along_x ? x0 : y0, to = along_x ? x1 : y1;
        for (double at = from; at < to - 1;) {
          const double wide = std::min(random.uniform(5, 9), to - at),
                       deep = random.uniform(6, 7.5), tall = random.uniform(7, 14);
          const double middle = at + wide / 2, in = deep / 2 + random.uniform(0, 0.4);
          const double x = along_x ? middle : (side == 2 ? x0 + in : x1 - in),
                       y = along_x ? (side == 0 ? y0 + in : y1 - in) : middle;
          w.box("house front", x, y, -1,
                along_x ? Vector3d(wide, deep, tall + 1) : Vector3d(deep, wide, tall + 1));
          if (random.chance(0.3))
            w.box("balcony", x, y, random.uniform(3, 4),
                  along_x ? Vector3d(1.8, deep + 1.6, 1) : Vector3d(deep + 1.6, 1.8, 1));
          at += wide;
        }
      }
    }
  }
  for (size_t i = 0; i < xs.size(); ++i) {
    for (size_t j = 0; j < ys.size(); ++j) {
      for (int k = 0; k < 3; ++k) {
        const bool along_x = random.chance(0.5);
        const double u = random.uniform(3, 22), v = (random.chance(0.5) ? 1 : -1) * 2.1;
        const double x = xs[i] + (along_x ? u : v), y = ys[j] + (along_x ? v : u);
        const int kind = random.below(4);
        if (kind == 0) w.post("lantern", x, y, 0, 3.6, 0.14);
        if (kind == 1) w.box("bench", x, y, 0, {0.5, 1.5, 0.9}, along_x ? kPi / 2 : 0);
        if (kind == 2) w.post("bollard", x, y, 0, 1, 0.25);
        if (kind == 3) w.ball("planter", x, y, 0, {0.9, 0.9, 1.2});
      }
    }
  }
  const size_t a = 0, b = xs.size() - 2, c = ys.size() - 2;
  w.route = {{xs[a], ys[0]}, {xs[b], ys[0]}, {xs[b], ys[1]}, {xs[1], ys[1]},
             {xs[1], ys[c]}, {xs[b], ys[c]}, {xs[b], ys[1]}};
  return w;
}

World motorway(Random& random) {
  World w;
  const int lanes = w.named("carriageway"), verge = w.named("verge");
  w.ground = [=](double, double y) { return std::abs(y) < 12 ? lanes : verge; };
  w.route = {{-230, -5}, {230, -5}};
  for (double x = -290; x < 290; x += 20) {
    w.box("guard rail", x, 0, 0.4, {20, 0.25, 0.4});
    if (random.chance(0.8)) w.box("guard rail", x, -12.5, 0.4, {20, 0.25, 0.4});
    if (random.chance(0.5)) w.box("noise barrier", x, -16, 0, {20, 0.3, 3.5});
    if (random.chance(0.5)) w.box("noise barrier", x, 16, 0, {20, 0.3, 3.5});
  }
  for (double x = -290; x < 290; x += random.uniform(35, 60)) w.post("mast", x, 0.6, 0, 10, 0.25);
  for (double x = -280; x < 290; x += random.uniform(25, 70)) {
    const double y = random.chance(0.5) ? -13.5 : 13.5;
    w.post("mast", x, y, 0, 3.5, 0.12);
    w.box("board", x, y, 2.2, {0.1, random.uniform(1, 2.5), 1.5});
  }
  for (double x = -200; x < 200; x += random.uniform(140, 200)) {
    w.box("bridge", x, 0, 6, {7, 60, 1.5});
    w.box("bridge", x, -18, 0, {7, 4, 6});
    w.box("bridge", x, 18, 0, {7, 4, 6});
  }
  for (int i = 0; i < 180; ++i) {
    const double y = random.uniform(18, 45) * (random.chance(0.5) ? 1 : -1);
    w.tree(random, random.uniform(-290, 290), y, "wood", "leaves");
  }
  return w;
}

World village(Random& random) {
  World w;
  w.height = [](double x, double y) { return 0.12 * x + 0.6 * std::sin(y / 23); };
  w.route = loop(random, 60, 7, 60);
  const int tar = w.named("tar"), grass = w.named("grass");
  w.ground = [=](double x, double y) { return w.distanceToRoute(x, y) < 3 ? tar : grass; };
  for (int i = 0; i < 170; ++i) {
    const double x = random.uniform(-100, 100), y = random.uniform(-100, 100),
                 away = w.distanceToRoute(x, y);
    if (away < 10 || away > 32) continue;
    const bool free = std::none_of(w.things.begin(), w.things.end(), [&](const Thing& t) {
      return (t.center.head<2>() - Vector2d(x, y)).norm() < 13;
    });
    if (free)
      w.box("house", x, y, -2,
            {random.uniform(7, 11), random.uniform(6, 10), random.uniform(6, 10)},
            random.uniform(0, 3));
  }
  for (int i = 0; i < 420; ++i) {
    const double x = random.uniform(-100, 100), y = random.uniform(-100, 100),
                 away = w.distanceToRoute(x, y);
    if (away < 4 || away > 30) continue;
    const int kind = random.below(5);
    if (kind < 2) w.tree(random, x, y, "wood", "leaves");
    if (kind == 2) w.ball("hedge", x, y, -0.2, {random.uniform(1, 3), 1.2, 1.8});
    if (kind == 3)
      w.box("wall", x, y, -0.5, {random.uniform(3, 8), 0.3, 1.8}, random.uniform(0, 3));
    if (kind == 4) w.post("pole", x, y, 0, random.uniform(3, 7), 0.18);
  }
  return w;
}

World carPark(Random& random) {
  World w;
  const int tar = w.named("tar");
  w.ground = [=](double, double) { return tar; };
  const double row = 17;
  for (int i = -4; i <= 4; ++i) {
    for (double x = -75; x < 75; x += 2.6) {
      for (int side = -1; side <= 1; side += 2) {
        if (random.chance(0.45))
          w.box("parked vehicle", x + random.uniform(-0.2, 0.2), i * row + side * 2.6, 0.2,
                {1.8, random.uniform(3.9, 4.8), random.uniform(1.3, 1.9)});
      }
    }
    for (double x = -75; x < 75; x += random.uniform(20, 40)) w.post("lamp", x, i * row, 0, 7, 0.2);
    for (int k = 0; k < 3; ++k) w.tree(random, random.uniform(-75, 75), i * row, "wood", "leaves");
    if (random.chance(0.5))
      w.box("trolley shelter", random.uniform(-60, 60), i * row, 0, {5, 2.2, 2.3});
  }
  for (int i = 0; i < 6; ++i)
    w.box("hall", random.uniform(-90, 90), (random.chance(0.5) ? 1 : -1) * 95, 0,
          {random.uniform(20, 45), 22, random.uniform(6, 12)});
  w.route = {{-78, -3.5 * row}, {78, -3.5 * row}, {78, -1.5 * row},
             {-78, -1.5 * row}, {-78, 0.5 * row}, {78, 0.5 * row}};
  return w;
}

void room(World& w, double x0, double x1, double y0, double y1, double tall,
          const std::string& wall) {
  w.box(wall, (x0 + x1) / 2, y0, 0, {x1 - x0, 0.2, tall});
  w.box(wall, (x0 + x1) / 2, y1, 0, {x1 - x0, 0.2, tall});
  w.box(wall, x0, (y0 + y1) / 2, 0, {0.2, y1 - y0, tall});
  w.box(wall, x1, (y0 + y1) / 2, 0, {0.2, y1 - y0, tall});
}

World warehouse(Random& random) {
  World w;
  w.step_m = 1;
  w.noise = 0.002;
  w.range_m = 30;
  w.roofed = true;
  const int floor = w.named("concrete");
  w.ground = [=](double, double) { return floor; };
  room(w, -32, 32, -26, 26, 8, "sheet wall");
  w.box("roof", 0, 0, 8, {64, 52, 0.3});
  const double aisle = 5.6;
  for (int i = -4; i <= 4; ++i) {
    const double y = i * aisle;
    for (double x = -24; x <= 24.1; x += 2.7) {
      for (int side = -1; side <= 1; side += 2) w.box("rack", x, y + side * 0.5, 0, {0.1, 0.1, 6});
      for (int level = 0; level < 3 && x < 23; ++level) {
        const double bottom = 1.9 * level;
        if (level) w.box("rack", x + 1.35, y, bottom - 0.1, {2.7, 1.1, 0.12});
        for (int k = 0; k < 2; ++k) {
          if (random.chance(0.72))
            w.box(random.chance(0.75) ? "carton" : "drum", x + 0.75 + 1.25 * k, y, bottom + 0.05,
                  {random.uniform(0.8, 1.15), 0.9, random.uniform(0.5, 1.5)});
        }
      }
    }
  }
  for (int i = 0; i < 14; ++i)
    w.box("pallet", random.uniform(-31, 31),
          (random.chance(0.5) ? 1 : -1) * random.uniform(0, 24.5), 0,
          {1.2, 0.8, random.uniform(0.15, 1.2)});
  w.route = {{-27.5, -2.5 * aisle}, {27.5, -2.5 * aisle}, {27.5, -0.5 * aisle},
             {-27.5, -0.5 * aisle}, {-27.5, 1.5 * aisle}, {27.5, 1.5 * aisle}};
  return w;
}

World home(Random& random) {
  World w;
  w.step_m = 0.2;
  w.eye_m = 1.4;
  w.noise = 0.002;
  w.range_m = 12;
  w.roofed = true;
  const int floor = w.named("parquet");
  w.ground = [=](double, double) { return floor; };
  const double split = random.uniform(-0.8, 0.8), tall = 2.6;
  room(w, -6, 6, -4.5, 4.5, tall, "plaster");
  w.box("plaster", 0, 0, tall, {12, 9, 0.2});
  const std::vector<double> xs{-6, -2 + split, 2 + split, 6};
  for (size_t i = 1; i < 3; ++i) {  // walls between the rooms, with doors at the corridor
    w.box("plaster", xs[i], 2.75, 0, {0.12, 3.5, tall});
    w.box("plaster", xs[i], -2.75, 0, {0.12, 3.5, tall});
  }
  std::vector<Vector2d> doors;
  for (int side = -1; side <= 1; side += 2) {
    for (size_t i = 0; i < 3; ++i) {
      const double door = random.uniform(xs[i] + 0.8, xs[i + 1] - 0.8), y = side * 1.0;
      w.box("plaster", (xs[i] + door - 0.45) / 2, y, 0, {door - 0.45 - xs[i], 0.12, tall});
      w.box("plaster", (xs[i + 1] + door + 0.45) / 2, y, 0, {xs[i + 1] - door - 0.45, 0.12, tall});
      doors.emplace_back(door, y);
      const double x0 = xs[i] + 0.2, x1 = xs[i + 1] - 0.2, back = side * 4.35;
      struct Piece {
        const char* name;
        Vector3d size;
      };
      const Piece pieces[] = {{"wardrobe", {1.4, 0.6, 2}},   {"couch", {2, 0.9, 0.8}},
                              {"shelf", {1, 0.35, 1.8}},     {"bedstead", {1.5, 2, 0.5}},
                              {"worktop", {1.6, 0.6, 0.9}},  {"telly", {1.2, 0.4, 1.2}},
                              {"armchair", {0.8, 0.8, 0.9}}, {"pot plant", {0.5, 0.5, 1.1}}};
      for (double x = x0; x < x1 - 0.6;) {
        const Piece& piece = pieces[random.below(8)];
        if (x + piece.size.x() > x1) break;
        w.box(piece.name, x + piece.size.x() / 2, back - side * piece.size.y() / 2, 0, piece.size);
        x += piece.size.x() + random.uniform(0.1, 0.6);
      }
      if (random.chance(0.6)) {
        const double x = std::clamp(door + random.uniform(-1.5, 1.5), x0 + 0.6, x1 - 0.6);
        if (std::abs(x - door) > 0.8) w.box("dining table", x, side * 2.1, 0.7, {0.9, 0.7, 0.05});
      }
    }
  }
  w.route = {{-5.4, 0}};
  std::vector<Vector2d> order = doors;
  std::sort(order.begin(), order.end(),
            [](const Vector2d& a, const Vector2d& b) { return a.x() < b.x(); });
  for (const Vector2d& door : order) {
    w.route.emplace_back(door.x(), 0);
    w.route.emplace_back(door.x(), 2.6 * (door.y() > 0 ? 1 : -1));
    w.route.emplace_back(door.x(), 0);
  }
  w.route.emplace_back(5.4, 0);
  return w;
}

// Rows and columns of a sensor, and the ray of each in its frame: z forward, x right, y down of a
// camera; x forward, y left, z up of a scanner.
struct Sensor {
  bool scanner;
  int width, height;
  double focal;

  Vector3d ray(int u, int v) const {
    if (!scanner)
      return Vector3d((u - (width - 1) / 2.0) / focal, (v - (height - 1) / 2.0) / focal, 1)
          .normalized();
    const double azimuth = (u + 0.5) * 2 * kPi / width - kPi,
                 up = (10 - 40.0 * v / (height - 1)) * kPi / 180;
    return {std::cos(azimuth) * std::cos(up), std::sin(azimuth) * std::cos(up), std::sin(up)};
  }
  // Columns and rows that a ball may cover; columns of a scanner may run past its seam.
  bool covers(const Vector3d& c, double r, int& u0, int& u1, int& v0, int& v1) const {
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
};

struct View {
  std::vector<double> range;  // m along each ray, infinity where nothing is
  std::vector<int> label;
};

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
      // The first change of sign of the height above ground, then bisection.
      double low = 0, high = -1;
      for (double t = 0.5; t < reach * 1.2; t *= 1.06) {
        const Vector3d at = from + t * along;
        if (at.z() < world.height(at.x(), at.y())) {
          high = t;
          break;
        }
        low = t;
      }
      if (high < 0) continue;
      for (int k = 0; k < 30; ++k) {
        const double t = (low + high) / 2;
        const Vector3d at = from + t * along;
        (at.z() < world.height(at.x(), at.y()) ? high : low) = t;
      }
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
    for (int v = v0; v <= v1; ++v) {
      for (int column = u0; column <= u1; ++column) {
        const int u = (column + sensor.width) % sensor.width;
        const size_t i = size_t(v) * size_t(sensor.width) + size_t(u);
        const double t = thing.hit(from, rays[i]);
        if (t < view.range[i]) view.range[i] = t, view.label[i] = thing.label;
      }
    }
  }
  return view;
}

// Some patches of an image get another class, as a network would.
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

void writePose(std::ofstream& out, const Isometry3d& pose) {
  for (int i = 0; i < 12; ++i) {
    char number[32];
    std::snprintf(number, sizeof number, "%.9g%c", pose.matrix()(i / 4, i % 4),
                  i < 11 ? ' ' : '\n');
    out << number;
  }
}

struct Session {
  std::string name;
  bool scanner;
  double yaw_deg, down_deg, above_m,
      aside_m;  // of the view against the way; above ground; to the left
  bool backwards, mapping;
};

void record(const World& world, const Session& session, const std::filesystem::path& folder,
            Random random) {
  namespace fs = std::filesystem;
  const Sensor sensor = session.scanner ? Sensor{true, 640, 32, 0} : Sensor{false, 320, 220, 170};
  for (const char* part :
       {session.scanner ? "velodyne" : "depth", session.scanner ? "labels" : "label"})
    fs::create_directories(folder / part);
  if (session.scanner) {
    std::ofstream(folder / "calib.txt") << "Tr: 1 0 0 0 0 1 0 0 0 0 1 0\n";
  } else {
    std::ofstream(folder / "camera.yaml")
        << "width: 320\nheight: 220\nfx: 170\nfy: 170\ncx: 159.5\ncy: 109.5\ndepth_scale: 0.001\n";
  }
  std::ofstream classes(folder / "classes.yaml"), poses(folder / "poses.txt"),
      truth(folder / "groundtruth.txt");
  classes << "- {id: 0, name: \"unlabelled\"}\n";
  for (size_t i = 0; i < world.classes.size(); ++i)
    classes << "- {id: " << i + 1 << ", name: \"" << world.classes[i] << "\"}\n";

  std::vector<Vector2d> route = world.route;
  if (session.backwards) std::reverse(route.begin(), route.end());
  const double reach = std::max(world.range_m, session.above_m * 3);
  Isometry3d odometry = Isometry3d::Identity(), before = Isometry3d::Identity();
  const double scale = 1 + (session.mapping ? 0 : 0.01 * random.normal()),
               turn = session.mapping ? 0 : 0.0004 * random.normal();
  double walked = 0, next = 0;
  int frame = 0;
  for (size_t leg = 0; leg + 1 < route.size(); ++leg) {
    const Vector2d way = route[leg + 1] - route[leg], ahead = way.normalized();
    for (; next <= walked + way.norm(); next += world.step_m, ++frame) {
      const Vector2d at =
          route[leg] + (next - walked) * ahead + session.aside_m * Vector2d(-ahead.y(), ahead.x());
      const double heading = std::atan2(ahead.y(), ahead.x()) + session.yaw_deg * kPi / 180,
                   down = session.down_deg * kPi / 180;
      const Vector3d z(std::cos(heading) * std::cos(down), std::sin(heading) * std::cos(down),
                       -std::sin(down));
      const Vector3d x(std::sin(heading), -std::cos(heading), 0);
      Isometry3d pose = Isometry3d::Identity();
      if (session.scanner) {
        pose.linear() << z, -x, z.cross(-x);
      } else {
        pose.linear() << x, z.cross(x), z;
      }
      pose.linear() =
          pose.linear() *
          Eigen::AngleAxisd(0.01 * random.normal(), Vector3d::UnitZ()).toRotationMatrix();
      pose.translation() << at,
          world.height(at.x(), at.y()) + (session.above_m > 0 ? session.above_m : world.eye_m);

      View view = cast(world, sensor, pose, reach);
      mislabel(view, sensor, int(world.classes.size()), session.mapping ? 0.08 : 0.12, random);
      if (frame) {
        Isometry3d moved = before.inverse() * pose;
        moved.translation() *= scale;
        moved.linear() =
            moved.linear() *
            Eigen::AngleAxisd(turn * world.step_m, pose.linear().transpose() * Vector3d::UnitZ())
                .toRotationMatrix();
        odometry = odometry * moved;
      } else {
        odometry = pose;
        if (!session.mapping)
          odometry = Isometry3d(Eigen::Translation3d(500, 300, 0) *
                                Eigen::AngleAxisd(1.1, Vector3d::UnitZ())) *
                     pose;
      }
      before = pose;
      writePose(poses, session.mapping ? pose : odometry);
      writePose(truth, pose);

      char name[32];
      if (session.scanner) {
        std::snprintf(name, sizeof name, "%06d.bin", frame);
        std::ofstream points(folder / "velodyne" / name, std::ios::binary);
        std::snprintf(name, sizeof name, "%06d.label", frame);
        std::ofstream labels(folder / "labels" / name, std::ios::binary);
        for (size_t i = 0; i < view.range.size(); ++i) {
          if (view.range[i] > reach) continue;
          const Vector3d hit = (view.range[i] + 0.02 * random.normal()) *
                               sensor.ray(int(i) % sensor.width, int(i) / sensor.width);
          const Eigen::Vector4f point(float(hit.x()), float(hit.y()), float(hit.z()), 0);
          const auto label = uint32_t(view.label[i] + 1);
          points.write(reinterpret_cast<const char*>(point.data()), sizeof point);
          labels.write(reinterpret_cast<const char*>(&label), sizeof label);
        }
        continue;
      }
      cv::Mat depth(sensor.height, sensor.width, CV_16U, cv::Scalar(0)),
          label(sensor.height, sensor.width, CV_8U, cv::Scalar(0));
      for (size_t i = 0; i < view.range.size(); ++i) {
        if (view.range[i] > reach) continue;
        const int u = int(i) % sensor.width, v = int(i) / sensor.width;
        double z_m = view.range[i] * sensor.ray(u, v).z();
        z_m += world.noise * z_m * z_m * random.normal();
        depth.at<uint16_t>(v, u) = uint16_t(std::clamp(z_m * 1000, 0.0, 65535.0));
        label.at<uint8_t>(v, u) = uint8_t(view.label[i] + 1);
      }
      std::snprintf(name, sizeof name, "%06d.png", frame);
      const std::vector<int> fast{cv::IMWRITE_PNG_COMPRESSION, 1};
      cv::imwrite((folder / "depth" / name).string(), depth, fast);
      cv::imwrite((folder / "label" / name).string(), label, fast);
    }
    walked += way.norm();
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::map<std::string, World (*)(Random&)> styles{
      {"forest", forest},     {"oldtown", oldTown},
      {"motorway", motorway}, {"village_slope", village},
      {"carpark", carPark},   {"warehouse", warehouse},
      {"home", home}};
  if (argc != 4 || !styles.count(argv[1])) {
    std::fprintf(stderr,
                 "usage: other_worlds forest|oldtown|motorway|village_slope|carpark|warehouse|home "
                 "SEED OUT_DIR\n");
    return 2;
  }
  Random random{std::mt19937_64(std::stoull(argv[2]))};
  const World world = styles.at(argv[1])(random);
  const bool indoors = world.roofed, small = world.step_m < 0.5;
  std::vector<Session> sessions{{"forward", false, 0, 6, 0, 0, false, true},
                                {"rear", false, 180, 6, 0, small ? 0.1 : 0.3, false, false},
                                {"oblique", false, 55, 6, 0, small ? -0.1 : -0.3, false, false}};
  if (!indoors) sessions.push_back({"aerial", false, 20, 60, 25, 2, false, false});
  if (!small) {
    sessions.push_back({"lidar", true, 0, 0, 0, 0, false, true});
    sessions.push_back({"lidar_reverse", true, 0, 0, 0, 0.4, true, false});
  }
  for (const Session& session : sessions) {
    Random of_session{std::mt19937_64(random.bits())};
    record(world, session, std::filesystem::path(argv[3]) / session.name, of_session);
  }
}
