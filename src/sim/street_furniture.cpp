// SPDX-License-Identifier: BSD-3-Clause
#include "xview/sim/street_furniture.h"

#include <cmath>

#include "xview/sim/town_labels.h"
#include "xview/types/pose.h"

namespace xview {
namespace {

constexpr double kFoot = 0.3;       // poles go this deep [m]
constexpr double kFromCurb = 0.45;  // [m]

Eigen::Vector3d up(double z) { return {0, 0, z}; }

/// A place beside a road with the direction that faces it.
struct Roadside {
  Eigen::Vector3d base;
  double yaw_to_road;  ///< of the direction to the middle of the road
  double yaw_of_street;
};

/// One side of one street: finds places for poles that are not on the road of a crossing street.
class StreetSide {
 public:
  StreetSide(const Site& site, const Street& street, double side)
      : site_(site),
        line_(street.centreline),
        side_(side),
        left_m_(side * (street.half_width_m + kFromCurb)) {}

  double length() const { return line_.length(); }

  bool isUsable(double along_m) const { return site_.field.toRoad(position(along_m)) > 0.25; }

  Roadside at(double along_m) const {
    const PolylinePoint p = line_.at(along_m);
    const double street = std::atan2(p.direction.y(), p.direction.x());
    return {site_.onGround(position(along_m)), street - side_ * M_PI / 2, street};
  }

 private:
  Eigen::Vector2d position(double along_m) const {
    const PolylinePoint p = line_.at(along_m);
    return p.position + left_m_ * p.left();
  }

  const Site& site_;
  ArcLength line_;
  double side_, left_m_;
};

void addLamp(Site& site, const Roadside& place, double height, double arm) {
  const Tag tag = site.tags.next(town_class::kPole);
  const Eigen::Vector3d top = place.base + up(height);
  addTube(site.mesh, place.base - up(kFoot), top, 0.09, 0.06, 6, tag);
  if (arm <= 0) {
    addTube(site.mesh, top, top + up(0.5), 0.22, 0.1, 6, tag);
    return;
  }
  const Eigen::Vector3d out(std::cos(place.yaw_to_road), std::sin(place.yaw_to_road), 0.1);
  addTube(site.mesh, top, top + arm * out, 0.05, 0.04, 5, tag);
  addBox(site.mesh, poseFromYaw(top + (arm + 0.3) * out, place.yaw_to_road), {0.7, 0.28, 0.14},
         tag);
}

void addUtilityPole(Site& site, const Roadside& place, double height) {
  const Tag tag = site.tags.next(town_class::kPole);
  addTube(site.mesh, place.base - up(kFoot), place.base + up(height), 0.15, 0.11, 7, tag);
  addBox(site.mesh, poseFromYaw(place.base + up(height - 0.8), place.yaw_to_road), {2, 0.12, 0.12},
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

void addSign(Site& site, const Roadside& place, double yaw, Random& random) {
  Tag tag = site.tags.next(town_class::kPole);
  const double height = random.uniform(2, 2.8), size = random.uniform(0.55, 0.85);
  addTube(site.mesh, place.base - up(kFoot), place.base + up(height), 0.035, 0.035, 5, tag);
  tag.label = town_class::kTrafficSign;
  const Eigen::Vector3d before(0.06 * std::cos(yaw), 0.06 * std::sin(yaw), 0);
  addPlate(site.mesh, place.base + before + up(height - size / 2), yaw, size,
           static_cast<int>(random.below(3)), tag);
}

void addTrafficLight(Site& site, const Roadside& place, double yaw) {
  Tag tag = site.tags.next(town_class::kPole);
  addTube(site.mesh, place.base - up(kFoot), place.base + up(3), 0.07, 0.07, 6, tag);
  tag.label = town_class::kTrafficLight;
  const Eigen::Vector3d before(0.2 * std::cos(yaw), 0.2 * std::sin(yaw), 0);
  addBox(site.mesh, poseFromYaw(place.base + before + up(2.3), yaw), {0.3, 0.35, 1.0}, tag);
}

void addLampsOf(Site& site, const Street& street, Random& random) {
  const double style = random.uniform();
  const double spacing = random.uniform(22, 36), height = random.uniform(4, 8);
  const double arm = style < 0.75 ? random.uniform(0.8, 2) : 0;
  const double first_side = random.uniform() < 0.5 ? -1 : 1;
  const bool alternate = random.uniform() < 0.5;
  double side = first_side;
  for (double s = random.uniform(4, 20); s < ArcLength(street.centreline).length(); s += spacing) {
    const StreetSide where(site, street, side);
    if (where.isUsable(s)) addLamp(site, where.at(s), height, arm);
    if (alternate) side = -side;
  }
}

void addUtilityPolesOf(Site& site, const Street& street, Random& random) {
  if (random.uniform() > 0.25) return;
  const StreetSide where(site, street, random.uniform() < 0.5 ? -1 : 1);
  const double spacing = random.uniform(28, 40), height = random.uniform(7, 10);
  for (double s = random.uniform(8, 25); s < where.length(); s += spacing) {
    if (where.isUsable(s)) addUtilityPole(site, where.at(s), height);
  }
}

/// Signs stand on the right and face the traffic that comes: against the street on its right side.
void addSignsOf(Site& site, const Street& street, Random& random) {
  for (const double side : {-1.0, 1.0}) {
    const StreetSide where(site, street, side);
    const double facing = side < 0 ? M_PI : 0;
    for (double s = 10; s < where.length(); s += 8) {
      const double place = s + random.uniform(-2, 2);
      const bool near_end = s < 14 || s > where.length() - 14;
      if (random.uniform() > (near_end ? 0.4 : 0.09) || !where.isUsable(place)) continue;
      const Roadside at = where.at(place);
      addSign(site, at, at.yaw_of_street + facing + random.uniform(-0.2, 0.2), random);
    }
  }
}

void addTrafficLightsOf(Site& site, const StreetNetwork& network, const Junction& junction,
                        int number, Random& random) {
  if (junction.streets.size() < 4 || random.uniform() > 0.4) return;
  for (const int i : junction.streets) {
    const Street& street = network.streets[i];
    const bool starts = street.from == number;
    const StreetSide where(site, street, starts ? 1 : -1);
    const double s = starts ? 8 : where.length() - 8;
    if (!where.isUsable(s)) continue;
    const Roadside at = where.at(s);
    addTrafficLight(site, at, at.yaw_of_street + (starts ? 0 : M_PI));
  }
}

}  // namespace

void addStreetFurniture(Site& site, const StreetNetwork& network, std::uint64_t seed) {
  for (std::size_t i = 0; i < network.streets.size(); ++i) {
    Random random(seed ^ 0x4655, i);
    addLampsOf(site, network.streets[i], random);
    addUtilityPolesOf(site, network.streets[i], random);
    addSignsOf(site, network.streets[i], random);
  }
  for (std::size_t i = 0; i < network.junctions.size(); ++i) {
    Random random(seed ^ 0x544C, i);
    addTrafficLightsOf(site, network, network.junctions[i], static_cast<int>(i), random);
  }
}

}  // namespace xview
