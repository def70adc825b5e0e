// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sim/render.h"
#include "sim/streets.h"
#include "xview/base/labels.h"

namespace xview {

/// Classes of the simulated towns: the ids of SYNTHIA, and terrain.
namespace town_class {
constexpr std::uint16_t kVoid = 0;
constexpr std::uint16_t kSky = 1;
constexpr std::uint16_t kBuilding = 2;
constexpr std::uint16_t kRoad = 3;
constexpr std::uint16_t kSidewalk = 4;
constexpr std::uint16_t kFence = 5;
constexpr std::uint16_t kVegetation = 6;
constexpr std::uint16_t kPole = 7;
constexpr std::uint16_t kCar = 8;
constexpr std::uint16_t kTrafficSign = 9;
constexpr std::uint16_t kPedestrian = 10;
constexpr std::uint16_t kBicycle = 11;
constexpr std::uint16_t kLaneMarking = 12;
constexpr std::uint16_t kHedge = 13;  ///< vegetation unless TownOptions::hedges_apart
constexpr std::uint16_t kTrafficLight = 15;
constexpr std::uint16_t kTerrain = 16;
constexpr std::uint16_t kCount = 17;
}  // namespace town_class

/// Their names, colours and roles.
LabelSet townLabels(bool hedges_apart = false);

/// Gentle hills: a sum of waves of 150 to 500 m length, evaluated on a triangulated grid of kCell,
/// so that finer triangulations of the same ground lie in the same planes.
class Relief {
 public:
  static constexpr double kCell = 4;  ///< [m]

  Relief(std::uint64_t seed, double amplitude_m);
  double at(const Eigen::Vector2d& p) const;  ///< height of sidewalks and gardens [m]

 private:
  struct Wave {
    Eigen::Vector2d number;  ///< [rad/m]
    double phase, amplitude_m;
  };
  double smooth(const Eigen::Vector2d& p) const;
  std::array<Wave, 5> waves_;
};

constexpr double kCurb = 0.12;  ///< roads lie lower than sidewalks by this [m]

/// A rectangle in the plane.
struct Footprint {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  double yaw = 0;
  Eigen::Vector2d size = Eigen::Vector2d::Ones();

  Eigen::Vector2d toWorld(const Eigen::Vector2d& p) const;
  double distanceTo(const Eigen::Vector2d& p) const;  ///< 0 inside [m]
};

/// True if two rectangles, the first grown by `gap_m` on all sides, have a point in common.
bool overlap(const Footprint& a, const Footprint& b, double gap_m);

/// Gives every object an instance of its own. There are 65535; a town of more objects uses them
/// again.
struct TagSource {
  std::uint16_t last = 0;
  Tag next(std::uint16_t label) {
    last = last == 65535 ? 1 : static_cast<std::uint16_t>(last + 1);
    return {label, last};
  }
};

/// Where a car may stand.
struct ParkingPlace {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  double yaw = 0;
};

/// A town without its traffic: what stands, and where there is room. World frame: x east, y north,
/// z up, metres, origin near the first junction.
struct Town {
  /// Streets and hills; nothing stands yet.
  explicit Town(const TownOptions& options);

  TownOptions options;
  StreetNetwork network;
  StreetField field;
  Relief relief;
  TriangleMesh mesh;
  std::vector<Footprint> houses;
  std::vector<ParkingPlace> parking;
  TagSource tags;  ///< traffic counts on from here

  /// The place on the ground: on the relief, less the curb on a road.
  Eigen::Vector3d onGround(const Eigen::Vector2d& p) const;
  /// Away from sidewalks, roads and houses by these distances.
  bool isFree(const Eigen::Vector2d& p, double from_sidewalk_m, double from_house_m) const;
  bool hasRoomFor(const Footprint& house) const;
  /// Random numbers for one purpose in one street: its own, or those of the pattern that alike
  /// streets follow.
  Random randomOfStreet(std::uint64_t purpose, std::size_t street) const;
};

/// Same options and seed: same town, on every machine.
Town makeTown(const TownOptions& options);

/// Parked cars, people and bicycles of one day; another seed is another day.
TriangleMesh makeTraffic(const Town& town, std::uint64_t day_seed);

}  // namespace xview
