// SPDX-License-Identifier: BSD-3-Clause
#include "sim/town.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/pose.h"
#include "building.h"

namespace xview {
namespace {

constexpr double kHouseGap = 1.0;           // between houses [m]
constexpr double kHouseFromSidewalk = 1.0;  // [m]
constexpr double kMargin = 90;              // ground and trees beyond the last street [m]
constexpr double kFoot = 0.3;               // poles go this deep [m]
constexpr double kFromCurb = 0.45;          // of poles [m]

/// True if the axes of `a` separate the rectangles.
bool axesSeparate(const Footprint& a, const Footprint& b, double gap_m) {
  const Eigen::Rotation2Dd to_a(-a.yaw);
  Eigen::AlignedBox2d box;
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {-0.5, 0.5}) {
      box.extend(to_a * (b.toWorld({x * b.size.x(), y * b.size.y()}) - a.center));
    }
  }
  const Eigen::Vector2d half = a.size / 2 + Eigen::Vector2d::Constant(gap_m);
  return box.min().x() > half.x() || box.max().x() < -half.x() || box.min().y() > half.y() ||
         box.max().y() < -half.y();
}

double yawOfDirection(const PolylinePoint& p) {
  return std::atan2(p.direction.y(), p.direction.x());
}

/// A place for a pole beside a road.
struct Roadside {
  Eigen::Vector3d base;
  double yaw_to_road;  ///< of the direction to the middle of the road
  double yaw_of_street;
};

/// Both curbs of one street.
struct Curbs {
  const Town& town;
  const Street& street;
  ArcLength line{street.centreline};

  /// side: 1 = left, -1 = right. Nothing if that is on the road of a crossing street.
  std::optional<Roadside> at(double along_m, double side) const {
    const PolylinePoint p = line.at(along_m);
    const double left_m = side * (street.half_width_m + kFromCurb);
    const Eigen::Vector2d place = p.position + left_m * p.left();
    if (town.field.toRoad(place) <= 0.25) return std::nullopt;
    const double yaw = yawOfDirection(p);
    return Roadside{town.onGround(place), yaw - side * M_PI / 2, yaw};
  }
};

void addLamp(Town& town, const Roadside& place, double height, double arm) {
  const Tag tag = town.tags.next(town_class::kPole);
  const Eigen::Vector3d top = place.base + up(height);
  addTube(town.mesh, place.base - up(kFoot), top, 0.09, 0.06, 6, tag);
  if (arm <= 0) {
    addTube(town.mesh, top, top + up(0.5), 0.22, 0.1, 6, tag);
    return;
  }
  const Eigen::Vector3d out(std::cos(place.yaw_to_road), std::sin(place.yaw_to_road), 0.1);
  addTube(town.mesh, top, top + arm * out, 0.05, 0.04, 5, tag);
  addBox(town.mesh, poseFromYaw(top + (arm + 0.3) * out, place.yaw_to_road), {0.7, 0.28, 0.14},
         tag);
}

void addUtilityPole(Town& town, const Roadside& place, double height) {
  const Tag tag = town.tags.next(town_class::kPole);
  addTube(town.mesh, place.base - up(kFoot), place.base + up(height), 0.15, 0.11, 7, tag);
  addBox(town.mesh, poseFromYaw(place.base + up(height - 0.8), place.yaw_to_road), {2, 0.12, 0.12},
         tag);
}

/// A plate across the street direction: round, square, or standing on a corner.
void addPlate(TriangleMesh& mesh, const Eigen::Vector3d& center, double yaw, double size, int shape,
              Tag tag) {
  const Eigen::Vector3d axis(std::cos(yaw), std::sin(yaw), 0);
  const Eigen::Vector3d behind = center - 0.02 * axis, before = center + 0.02 * axis;
  if (shape == 0) {
    addTube(mesh, behind, before, size / 2, size / 2, 10, tag);
  } else if (shape == 1) {
    addBox(mesh, poseFromYaw(center - up(size / 2), yaw), {0.04, size, 1.3 * size}, tag);
  } else {
    addTube(mesh, behind, before, 0.6 * size, 0.6 * size, 3, tag);
  }
}

void addSign(Town& town, const Roadside& place, double yaw, Random& random) {
  Tag tag = town.tags.next(town_class::kPole);
  const double height = random.uniform(2, 2.8), size = random.uniform(0.55, 0.85);
  addTube(town.mesh, place.base - up(kFoot), place.base + up(height), 0.035, 0.035, 5, tag);
  tag.label = town_class::kTrafficSign;
  const Eigen::Vector3d before(0.06 * std::cos(yaw), 0.06 * std::sin(yaw), 0);
  addPlate(town.mesh, place.base + before + up(height - size / 2), yaw, size,
           static_cast<int>(random.below(3)), tag);
}

void addTrafficLight(Town& town, const Roadside& place, double yaw) {
  Tag tag = town.tags.next(town_class::kPole);
  addTube(town.mesh, place.base - up(kFoot), place.base + up(3), 0.07, 0.07, 6, tag);
  tag.label = town_class::kTrafficLight;
  const Eigen::Vector3d before(0.2 * std::cos(yaw), 0.2 * std::sin(yaw), 0);
  addBox(town.mesh, poseFromYaw(place.base + before + up(2.3), yaw), {0.3, 0.35, 1.0}, tag);
}

void addLamps(Town& town, const Curbs& curbs, Random& random) {
  const double style = random.uniform();
  const double spacing = random.uniform(22, 36), height = random.uniform(4, 8);
  const double arm = style < 0.75 ? random.uniform(0.8, 2) : 0;
  double side = random.uniform() < 0.5 ? -1 : 1;
  const bool alternate = random.uniform() < 0.5;
  for (double s = random.uniform(4, 20); s < curbs.line.length(); s += spacing) {
    if (const auto place = curbs.at(s, side)) addLamp(town, *place, height, arm);
    if (alternate) side = -side;
  }
}

void addUtilityPoles(Town& town, const Curbs& curbs, Random& random) {
  if (random.uniform() > 0.25) return;
  const double side = random.uniform() < 0.5 ? -1 : 1;
  const double spacing = random.uniform(28, 40), height = random.uniform(7, 10);
  for (double s = random.uniform(8, 25); s < curbs.line.length(); s += spacing) {
    if (const auto place = curbs.at(s, side)) addUtilityPole(town, *place, height);
  }
}

/// Signs stand on the right and face the traffic that comes: against the street on its right side.
void addSigns(Town& town, const Curbs& curbs, Random& random) {
  const double length = curbs.line.length();
  for (const double side : {-1.0, 1.0}) {
    const double facing = side < 0 ? M_PI : 0;
    for (double s = 10; s < length; s += 8) {
      const auto place = curbs.at(s + random.uniform(-2, 2), side);
      const bool near_end = s < 14 || s > length - 14;
      if (random.uniform() > (near_end ? 0.4 : 0.09) || !place) continue;
      addSign(town, *place, place->yaw_of_street + facing + random.uniform(-0.2, 0.2), random);
    }
  }
}

void addTrafficLights(Town& town, int junction, Random& random) {
  const std::vector<int>& streets = town.network.junctions[junction].streets;
  if (streets.size() < 4 || random.uniform() > 0.4) return;
  for (const int i : streets) {
    const Curbs curbs{town, town.network.streets[i]};
    const bool starts = curbs.street.from == junction;
    const auto place = curbs.at(starts ? 8 : curbs.line.length() - 8, starts ? 1 : -1);
    if (place) addTrafficLight(town, *place, place->yaw_of_street + (starts ? 0 : M_PI));
  }
}

/// Lamps, utility poles, signs and traffic lights along all streets.
void addStreetFurniture(Town& town) {
  for (std::size_t i = 0; i < town.network.streets.size(); ++i) {
    Random random = town.randomOfStreet(0x4655, i);
    const Curbs curbs{town, town.network.streets[i]};
    addLamps(town, curbs, random);
    addUtilityPoles(town, curbs, random);
    addSigns(town, curbs, random);
  }
  for (std::size_t i = 0; i < town.network.junctions.size(); ++i) {
    Random random(town.options.seed ^ 0x544C, i);
    addTrafficLights(town, static_cast<int>(i), random);
  }
}

/// Parking places at the curb, half on the sidewalk.
void addParkingAtCurbs(Town& town) {
  constexpr double kSpacing = 6.5, kFromEnd = 10;
  for (const Street& street : town.network.streets) {
    const ArcLength line(street.centreline);
    for (const double side : {-1.0, 1.0}) {
      for (double s = kFromEnd; s < line.length() - kFromEnd; s += kSpacing) {
        const PolylinePoint p = line.at(s);
        const Eigen::Vector2d place = p.position + side * (street.half_width_m + 0.4) * p.left();
        if (town.field.toRoad(place) < -0.3) continue;
        const double yaw = yawOfDirection(p);
        town.parking.push_back({place, side < 0 ? yaw : yaw + M_PI});
      }
    }
  }
}

/// People and bicycles on the sidewalks of one street.
void addSidewalkLife(TriangleMesh& mesh, const Town& town, const Street& street, TagSource& tags,
                     Random& random) {
  const ArcLength line(street.centreline);
  for (double s = random.uniform(0, 30); s < line.length(); s += random.uniform(8, 60)) {
    const double side = random.uniform() < 0.5 ? -1 : 1;
    const PolylinePoint p = line.at(s);
    const double out = street.half_width_m + street.sidewalk_m * random.uniform(0.3, 0.9);
    const Eigen::Vector2d place = p.position + side * out * p.left();
    const double yaw = yawOfDirection(p) + random.uniform(-0.3, 0.3);
    const bool is_person = random.uniform() < 0.7;
    if (town.field.toRoad(place) < 0.3) continue;
    const Eigen::Isometry3d T = poseFromYaw(town.onGround(place), yaw);
    if (is_person) {
      addPerson(mesh, T, random, tags.next(town_class::kPedestrian));
    } else {
      addBicycle(mesh, T, tags.next(town_class::kBicycle));
    }
  }
}

}  // namespace

LabelSet townLabels(bool hedges_apart) {
  using namespace town_class;
  const ClassInfo classes[] = {
      {kVoid, "void", {0, 0, 0}, Role::ignored, Kind::none, false},
      {kSky, "sky", {128, 128, 128}, Role::ignored, Kind::none, false},
      {kBuilding, "building", {128, 0, 0}, Role::surface, Kind::building, false},
      {kRoad, "road", {128, 64, 128}, Role::surface, Kind::road, false},
      {kSidewalk, "sidewalk", {0, 0, 192}, Role::surface, Kind::sidewalk, false},
      {kFence, "fence", {64, 64, 128}, Role::surface, Kind::fence, false},
      {kVegetation, "vegetation", {128, 128, 0}, Role::surface, Kind::vegetation, false},
      {kPole, "pole", {192, 192, 128}, Role::object, Kind::pole, false},
      {kCar, "car", {64, 0, 128}, Role::dynamic, Kind::vehicle, false},
      {kTrafficSign, "traffic sign", {192, 128, 128}, Role::object, Kind::sign, false},
      {kPedestrian, "pedestrian", {64, 64, 0}, Role::dynamic, Kind::none, false},
      {kBicycle, "bicycle", {0, 128, 192}, Role::dynamic, Kind::none, false},
      {kLaneMarking, "lane marking", {0, 172, 0}, Role::surface, Kind::lane_marking, false},
      {kTrafficLight, "traffic light", {0, 128, 128}, Role::object, Kind::light, false},
      {kTerrain, "terrain", {152, 251, 152}, Role::surface, Kind::terrain, false}};
  LabelSet set("town");
  for (const ClassInfo& info : classes) set.add(info);
  if (hedges_apart)
    set.add({kHedge, "hedge", {76, 115, 0}, Role::surface, Kind::vegetation, false});
  return set;
}

Eigen::Vector2d Footprint::toWorld(const Eigen::Vector2d& p) const {
  return center + Eigen::Rotation2Dd(yaw) * p;
}

double Footprint::distanceTo(const Eigen::Vector2d& p) const {
  const Eigen::Vector2d local = Eigen::Rotation2Dd(-yaw) * (p - center);
  return (local.cwiseAbs() - size / 2).cwiseMax(0).norm();
}

bool overlap(const Footprint& a, const Footprint& b, double gap_m) {
  const double reach_m = (a.size.norm() + b.size.norm()) / 2 + 1.5 * gap_m;
  if ((a.center - b.center).norm() > reach_m) return false;
  return !axesSeparate(a, b, gap_m) && !axesSeparate(b, a, gap_m);
}

Town::Town(const TownOptions& town_options)
    : options(town_options),
      network(makeStreets(options)),
      field(network),
      relief(options.seed, options.relief_m) {}

Eigen::Vector3d Town::onGround(const Eigen::Vector2d& p) const {
  return {p.x(), p.y(), relief.at(p) - (field.toRoad(p) < 0 ? kCurb : 0)};
}

bool Town::isFree(const Eigen::Vector2d& p, double from_sidewalk_m, double from_house_m) const {
  if (field.toSidewalk(p) < from_sidewalk_m || field.toRoad(p) < from_sidewalk_m) return false;
  return std::none_of(houses.begin(), houses.end(),
                      [&](const Footprint& house) { return house.distanceTo(p) < from_house_m; });
}

bool Town::hasRoomFor(const Footprint& house) const {
  for (int i = -2; i <= 2; ++i) {
    for (int j = -2; j <= 2; ++j) {
      const Eigen::Vector2d p = house.toWorld({i * house.size.x() / 4, j * house.size.y() / 4});
      if (field.toSidewalk(p) < kHouseFromSidewalk) return false;
    }
  }
  return std::none_of(houses.begin(), houses.end(),
                      [&](const Footprint& other) { return overlap(house, other, kHouseGap); });
}

Random Town::randomOfStreet(std::uint64_t purpose, std::size_t street) const {
  const double alike = options.alike;
  if (alike > 0 && Random(options.seed ^ purpose ^ 0x414C, street).uniform() < alike)
    return Random(options.pattern_seed ^ purpose, 0x5041);
  return Random(options.seed ^ purpose, street);
}

Town makeTown(const TownOptions& options) {
  Town town(options);
  addLots(town);
  addStreetTrees(town);
  addWilderness(town, kMargin);
  addStreetFurniture(town);
  addGround(town, kMargin);
  addLaneMarkings(town);
  addParkingAtCurbs(town);
  return town;
}

TriangleMesh makeTraffic(const Town& town, std::uint64_t day_seed) {
  TriangleMesh mesh;
  TagSource tags = town.tags;
  for (std::size_t i = 0; i < town.parking.size(); ++i) {
    Random random(day_seed ^ 0x4341, i);
    if (random.uniform() >= town.options.car_density) continue;
    const ParkingPlace& place = town.parking[i];
    const Eigen::Vector2d shift{random.uniform(-0.5, 0.5), random.uniform(-0.1, 0.1)};
    const Eigen::Vector2d p = place.position + Eigen::Rotation2Dd(place.yaw) * shift;
    const double turn = random.uniform() < 0.15 ? M_PI : random.uniform(-0.04, 0.04);
    addCar(mesh, poseFromYaw(town.onGround(p), place.yaw + turn), random,
           tags.next(town_class::kCar));
  }
  for (std::size_t i = 0; i < town.network.streets.size(); ++i) {
    Random random(day_seed ^ 0x5057, i);
    addSidewalkLife(mesh, town, town.network.streets[i], tags, random);
  }
  return mesh;
}

}  // namespace xview
