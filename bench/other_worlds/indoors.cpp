// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "styles.h"

namespace other_worlds {
namespace {

// Four walls about a rectangle.
void room(World& w, double x0, double x1, double y0, double y1, double tall,
          const std::string& wall) {
  w.box(wall, (x0 + x1) / 2, y0, 0, {x1 - x0, 0.2, tall});
  w.box(wall, (x0 + x1) / 2, y1, 0, {x1 - x0, 0.2, tall});
  w.box(wall, x0, (y0 + y1) / 2, 0, {0.2, y1 - y0, tall});
  w.box(wall, x1, (y0 + y1) / 2, 0, {0.2, y1 - y0, tall});
}

}  // namespace

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
  for (size_t i = 1; i < 3; ++i) {  // The walls between the rooms of a side.
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

}  // namespace other_worlds
