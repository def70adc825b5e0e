// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "styles.h"

namespace other_worlds {
namespace {

constexpr double kAnyDistance = std::numeric_limits<double>::infinity();

// A closed way about the origin whose radius varies by a few waves.
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

}  // namespace

World forest(Random& random) {
  World w;
  const double p = random.uniform(0, 6), q = random.uniform(0, 6);
  w.relief = [=](double x, double y) {
    return 3 * std::sin(x / 37 + p) + 2.5 * std::sin(y / 29 + q) + 0.4 * std::sin((x + y) / 7);
  };
  w.route = loop(random, 65, 6, 72);
  const int track = w.named("gravel track"), soil = w.named("soil");
  w.ground = [=](double x, double y) { return w.distanceToRoute(x, y) < 1.8 ? track : soil; };
  w.scatter(random, 1700, 115, 2.6, 45, [&](double x, double y) {
    const double tall = random.uniform(5, 11);
    w.post("trunk", x, y, -0.5, tall + 1, random.uniform(0.25, 0.7));
    const double wide = random.uniform(3, 6);
    w.ball("crown", x, y, tall - 2, {wide, wide, random.uniform(4, 7)});
  });
  w.scatter(random, 260, 110, 2.2, kAnyDistance, [&](double x, double y) {
    const double s = random.uniform(0.5, 1.8);
    w.ball(random.chance(0.6) ? "shrub" : "boulder", x, y, -0.2,
           {s, s * random.uniform(0.7, 1.3), s * 0.9});
  });
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
  w.relief = [](double x, double y) { return 0.12 * x + 0.6 * std::sin(y / 23); };
  w.route = loop(random, 60, 7, 60);
  const int tar = w.named("tar"), grass = w.named("grass");
  w.ground = [=](double x, double y) { return w.distanceToRoute(x, y) < 3 ? tar : grass; };
  w.scatter(random, 170, 100, 10, 32, [&](double x, double y) {
    const bool free = std::none_of(w.things.begin(), w.things.end(), [&](const Thing& t) {
      return (t.center.head<2>() - Vector2d(x, y)).norm() < 13;
    });
    if (free)
      w.box("house", x, y, -2,
            {random.uniform(7, 11), random.uniform(6, 10), random.uniform(6, 10)},
            random.uniform(0, 3));
  });
  w.scatter(random, 420, 100, 4, 30, [&](double x, double y) {
    const int kind = random.below(5);
    if (kind < 2) w.tree(random, x, y, "wood", "leaves");
    if (kind == 2) w.ball("hedge", x, y, -0.2, {random.uniform(1, 3), 1.2, 1.8});
    if (kind == 3)
      w.box("wall", x, y, -0.5, {random.uniform(3, 8), 0.3, 1.8}, random.uniform(0, 3));
    if (kind == 4) w.post("pole", x, y, 0, random.uniform(3, 7), 0.18);
  });
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

}  // namespace other_worlds
