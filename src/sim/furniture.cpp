// SPDX-License-Identifier: BSD-3-Clause
#include "furniture.h"

#include <algorithm>
#include <cmath>

#include "base/pose.h"
#include "building.h"
#include "xview/base/labels.h"

namespace xview {

using namespace office_class;

namespace {

constexpr double kAttempts = 6;  // to find room for a thing

void addChair(TriangleMesh& mesh, const Eigen::Isometry3d& T, Tag tag) {
  addTube(mesh, pointAt(T, 0, 0, 0.06), pointAt(T, 0, 0, 0.42), 0.04, 0.04, 5, tag);
  addTube(mesh, pointAt(T, 0, 0, 0.02), pointAt(T, 0, 0, 0.08), 0.28, 0.1, 7, tag);
  addBox(mesh, moved(T, 0, 0, 0.42), {0.46, 0.46, 0.08}, tag);
  addBox(mesh, moved(T, -0.22, 0, 0.5), {0.06, 0.42, 0.5}, tag);
}

/// Something small beside one of the long edges of a space.
void addLooseThing(TriangleMesh& mesh, const Footprint& space, TagSource& tags, Random& random) {
  const double side = random.uniform() < 0.5 ? -0.5 : 0.5;
  const Eigen::Vector2d p =
      space.toWorld({random.uniform(-0.5, 0.5) * space.size.x(), side * space.size.y()});
  const Eigen::Isometry3d T = poseFromYaw({p.x(), p.y(), 0}, random.uniform(0, 2 * M_PI));
  const double kind = random.uniform();
  if (kind < 0.55) {
    const double size = random.uniform(0.25, 0.5);
    addBox(mesh, T, {size, 0.8 * size, random.uniform(0.2, 0.45)}, tags.next(kBox));
  } else if (kind < 0.85) {
    addBox(mesh, T, {0.35, 0.2, 0.35}, tags.next(kBag), {0.6, 0.5});
  } else {
    addPerson(mesh, T, random, tags.next(kPerson));
  }
}

}  // namespace

bool Furnisher::isFree(const Footprint& footprint, double low, double high) const {
  return std::none_of(taken_.begin(), taken_.end(), [&](const Taken& t) {
    return low < t.high && high > t.low && overlap(footprint, t.footprint, 0.02);
  });
}

/// T_world_thing of something that stands or hangs at a wall: on the floor, y into the room.
std::optional<Eigen::Isometry3d> Furnisher::atWall(Wall wall, const Eigen::Vector3d& size,
                                                   double low) {
  for (int i = 0; i < kAttempts; ++i) {
    const Wall chosen = wall == any ? static_cast<Wall>(random_.below(4)) : wall;
    const bool along_x = chosen == south || chosen == north;
    const double length = along_x ? area_.size.x() : area_.size.y();
    const double margin = area_.wall_m / 2 + 0.01, spare = length - size.x() - 2 * margin;
    const double along = margin + size.x() / 2 + std::max(0.0, spare) * random_.uniform();
    const double out = margin + size.y() / 2;
    if (spare < 0) continue;
    Footprint footprint{{along, out}, 0, size.head<2>()};
    if (chosen == north) footprint = {{along, area_.size.y() - out}, M_PI, size.head<2>()};
    if (chosen == east) footprint = {{area_.size.x() - out, along}, M_PI / 2, size.head<2>()};
    if (chosen == west) footprint = {{out, along}, -M_PI / 2, size.head<2>()};
    if (!isFree(footprint, low, low + size.z())) continue;
    taken_.push_back({footprint, low, low + size.z()});
    return T_world_area_ *
           poseFromYaw({footprint.center.x(), footprint.center.y(), 0}, footprint.yaw);
  }
  return std::nullopt;
}

bool Furnisher::addThing(std::uint16_t label, Wall wall, const Eigen::Vector3d& size, double low) {
  const auto T = atWall(wall, size, low);
  if (T) addBox(office_.mesh, moved(*T, 0, 0, low), size, office_.tags.next(label));
  return T.has_value();
}

void Furnisher::addDesk() {
  const Eigen::Vector3d size(random_.uniform(1.3, 1.8), random_.uniform(0.7, 0.85), 0.74);
  const auto T = atWall(any, size);
  if (!T) return;
  const Tag tag = office_.tags.next(kWritingDesk);
  addBox(office_.mesh, moved(*T, 0, 0, 0.7), {size.x(), size.y(), 0.04}, tag);
  for (const double side : {-0.5, 0.5}) {
    addBox(office_.mesh, moved(*T, side * (size.x() - 0.06), 0, 0), {0.04, size.y() - 0.1, 0.7},
           tag);
  }
  const double x = random_.uniform(-0.25, 0.25) * size.x();
  const Tag screen = office_.tags.next(kMonitor);
  addBox(office_.mesh, moved(*T, x, -0.15, 0.86), {random_.uniform(0.45, 0.65), 0.05, 0.36},
         screen);
  addBox(office_.mesh, moved(*T, x, -0.15, 0.74), {0.2, 0.15, 0.12}, screen, {0.3, 0.3});
  const Eigen::Vector3d seat = pointAt(*T, x, size.y() / 2 + 0.25, 0);
  office_.seats.push_back({seat.head<2>(), yawOf(T->linear()) - M_PI / 2});
}

void Furnisher::addSeatingGroup() {
  const auto T = atWall(any, {1.6, 0.85, 0.8});
  if (!T) return;
  const Tag tag = office_.tags.next(kSofa);
  addBox(office_.mesh, *T, {1.6, 0.85, 0.42}, tag);
  addBox(office_.mesh, moved(*T, 0, -0.34, 0.42), {1.6, 0.17, 0.38}, tag);
  addThing(kTable, any, {random_.uniform(0.6, 1.1), 0.6, random_.uniform(0.42, 0.75)});
}

void Furnisher::addWindow() {
  const double width = random_.uniform(0.9, 1.5);
  const auto T = atWall(north, {width, 0.05, 1.3}, 0.9);
  if (!T) return;
  addBox(office_.mesh, moved(*T, 0, 0, 0.9), {width, 0.05, 1.3}, office_.tags.next(kWindow));
  addBox(office_.mesh, moved(*T, 0, 0.05, 0.12), {0.8 * width, 0.12, 0.6},
         office_.tags.next(kRadiator));
  if (random_.uniform() < 0.4)
    addBox(office_.mesh, moved(*T, 0.5 * width, 0.06, 0.5), {0.35, 0.08, 1.9},
           office_.tags.next(kCurtain));
}

void Furnisher::addPlant() {
  const double radius = random_.uniform(0.18, 0.35), height = random_.uniform(0.6, 1.5);
  const auto T = atWall(any, {2 * radius, 2 * radius, height});
  if (!T) return;
  const Tag tag = office_.tags.next(kPlant);
  addTube(office_.mesh, pointAt(*T, 0, 0, 0), pointAt(*T, 0, 0, 0.3), 0.13, 0.17, 8, tag);
  addLumpyEllipsoid(office_.mesh, pointAt(*T, 0, 0, 0.3 + 0.5 * (height - 0.3)),
                    {radius, radius, 0.5 * (height - 0.3)}, 0.2, random_, tag);
}

void Furnisher::addBin() {
  const auto T = atWall(any, {0.34, 0.34, 0.4});
  if (!T) return;
  addTube(office_.mesh, pointAt(*T, 0, 0, 0), pointAt(*T, 0, 0, 0.38), 0.13, 0.16, 8,
          office_.tags.next(kTrashBin));
}

void Furnisher::addExtinguisher() {
  const auto T = atWall(any, {0.2, 0.2, 0.6}, 0.5);
  if (!T) return;
  addTube(office_.mesh, pointAt(*T, 0, 0, 0.5), pointAt(*T, 0, 0, 1.05), 0.09, 0.07, 8,
          office_.tags.next(kExtinguisher));
}

void Furnisher::addLamps(double spacing_m) {
  const int count = std::max(1, static_cast<int>(area_.size.x() / spacing_m));
  for (int i = 0; i < count; ++i) {
    const double along = (i + 0.5) * area_.size.x() / count;
    addBox(office_.mesh, moved(T_world_area_, along, area_.size.y() / 2, area_.height_m - 0.08),
           {1.2, 0.3, 0.08}, office_.tags.next(kLamp));
  }
}

void Furnisher::furnishRoom() {
  addLamps(3);
  for (int i = some(1, 3); i > 0; --i) addWindow();
  if (random_.uniform() < 0.15) addThing(kPillar, any, {0.4, 0.4, area_.height_m});
  for (int i = some(1, 3.6); i > 0; --i) addDesk();
  for (int i = some(0, 2.5); i > 0; --i)
    addThing(kBookshelf, any, {random_.uniform(0.8, 1.2), 0.33, random_.uniform(1.6, 2.1)});
  for (int i = some(0, 2.8); i > 0; --i)
    addThing(kCabinet, any,
             {random_.uniform(0.5, 1.1), random_.uniform(0.4, 0.6), random_.uniform(0.7, 2)});
  if (random_.uniform() < 0.25) addSeatingGroup();
  if (random_.uniform() < 0.6) addThing(kWhiteboard, any, {random_.uniform(1.2, 2), 0.04, 1}, 0.95);
  for (int i = some(0, 3); i > 0; --i)
    addThing(kPicture, any, {random_.uniform(0.4, 0.9), 0.04, random_.uniform(0.3, 0.6)}, 1.4);
  if (random_.uniform() < 0.4) addPlant();
  if (random_.uniform() < 0.7) addBin();
}

void Furnisher::furnishCorridor() {
  addLamps(3.6);
  for (int i = some(0.5, 0.9 * area_.size.x()); i > 0; --i) {
    const double kind = random_.uniform();
    if (kind < 0.3) {
      addThing(kPicture, any, {random_.uniform(0.4, 1.2), 0.04, random_.uniform(0.3, 0.8)}, 1.2);
    } else if (kind < 0.45) {
      addThing(kWhiteboard, any, {random_.uniform(0.8, 1.6), 0.04, 0.9}, 1);
    } else if (kind < 0.63) {
      addThing(kCabinet, any, {random_.uniform(0.5, 1.2), 0.4, random_.uniform(0.8, 1.9)});
    } else if (kind < 0.73) {
      addThing(kPillar, any, {random_.uniform(0.25, 0.4), 0.2, area_.height_m});
    } else if (kind < 0.82) {
      addThing(kRadiator, any, {random_.uniform(0.6, 1.4), 0.12, 0.6}, 0.1);
    } else if (kind < 0.9) {
      addExtinguisher();
    } else {
      random_.uniform() < 0.5 ? addPlant() : addBin();
    }
  }
}

TriangleMesh makeClutter(const Office& office, std::uint64_t day_seed) {
  TriangleMesh mesh;
  TagSource tags = office.tags;
  for (std::size_t i = 0; i < office.seats.size(); ++i) {
    Random random(day_seed ^ 0x4348, i);
    if (random.uniform() < 0.08) continue;
    const Seat& seat = office.seats[i];
    const Eigen::Vector2d p =
        seat.position + Eigen::Vector2d(random.uniform(-0.35, 0.35), random.uniform(-0.35, 0.35));
    addChair(mesh, poseFromYaw({p.x(), p.y(), 0}, seat.yaw + random.uniform(-0.8, 0.8)),
             tags.next(kChair));
  }
  for (std::size_t i = 0; i < office.floor_space.size(); ++i) {
    Random random(day_seed ^ 0x4C54, i);
    const int things = static_cast<int>(office.options.clutter * random.uniform(0, 2.5));
    for (int k = 0; k < things; ++k) addLooseThing(mesh, office.floor_space[i], tags, random);
  }
  return mesh;
}

LabelSet officeLabels() {
  struct Named {
    std::uint16_t id;
    const char* name;
    Role role;
  };
  constexpr Role kSurface = Role::surface, kObject = Role::object, kMoves = Role::dynamic;
  const Named classes[] = {{0, "void", Role::ignored},
                           {town_class::kSky, "sky", Role::ignored},
                           {kWallClass, "wall", kSurface},
                           {kFloor, "floor", kSurface},
                           {kCeiling, "ceiling", kSurface},
                           {kDoor, "door", kObject},
                           {kWindow, "window", kObject},
                           {kCabinet, "cabinet", kObject},
                           {kBookshelf, "bookshelf", kObject},
                           {kWritingDesk, "desk", kObject},
                           {kTable, "table", kObject},
                           {kChair, "chair", kMoves},
                           {kSofa, "sofa", kObject},
                           {kWhiteboard, "whiteboard", kObject},
                           {kPicture, "picture", kObject},
                           {kMonitor, "monitor", kObject},
                           {kLamp, "lamp", kObject},
                           {kRadiator, "radiator", kObject},
                           {kPlant, "plant", kObject},
                           {kTrashBin, "trash bin", kObject},
                           {kExtinguisher, "fire extinguisher", kObject},
                           {kPillar, "pillar", kObject},
                           {kCurtain, "curtain", kObject},
                           {kBox, "box", kMoves},
                           {kBag, "bag", kMoves},
                           {kPerson, "person", kMoves}};
  LabelSet set("office");
  for (const Named& c : classes) {
    const Kind guess = ClassNames::shipped().kind(c.name);
    const Kind as_object = isPoleLike(guess) ? guess : Kind::other_object;
    const Kind kind = c.role == kSurface ? guess : c.role == kObject ? as_object : Kind::none;
    set.add({c.id, c.name, distinctColor(c.id), c.role, kind, false});
  }
  return set;
}

}  // namespace xview
