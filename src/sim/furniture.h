// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "sim/office.h"

namespace xview {

namespace office_class {
constexpr std::uint16_t kWallClass = 32, kFloor = 33, kCeiling = 34, kDoor = 35, kWindow = 36,
                        kCabinet = 37, kBookshelf = 38, kWritingDesk = 39, kTable = 40, kChair = 41,
                        kSofa = 42, kWhiteboard = 43, kPicture = 44, kMonitor = 45, kLamp = 46,
                        kRadiator = 47, kPlant = 48, kTrashBin = 49, kExtinguisher = 50,
                        kPillar = 51, kCurtain = 52, kBox = 53, kBag = 54, kPerson = 55;
}  // namespace office_class

/// A rectangle of floor between four walls.
struct Area {
  Eigen::Vector2d size;  ///< between the middles of the walls [m]
  double wall_m, height_m;
};

/// Puts things where nothing stands or hangs yet. Area frame: origin at a corner, x and y along the
/// walls, z up.
class Furnisher {
 public:
  Furnisher(Office& office, const Area& area, const Eigen::Isometry3d& T_world_area, Random& random)
      : office_(office), area_(area), T_world_area_(T_world_area), random_(random) {}

  /// Nothing will stand there, up to the height of a person.
  void keepFree(const Footprint& space) { taken_.push_back({space, 0, 2.1}); }
  void furnishRoom();
  void furnishCorridor();

 private:
  enum Wall { south, east, north, west, any };
  struct Taken {
    Footprint footprint;
    double low, high;
  };

  bool isFree(const Footprint& footprint, double low, double high) const;
  std::optional<Eigen::Isometry3d> atWall(Wall wall, const Eigen::Vector3d& size, double low = 0);
  bool addThing(std::uint16_t label, Wall wall, const Eigen::Vector3d& size, double low = 0);
  void addDesk();
  void addSeatingGroup();
  void addWindow();
  void addPlant();
  void addBin();
  void addExtinguisher();
  void addLamps(double spacing_m);
  /// A number of times: at least `low`, fewer than `high`, both times the clutter of the floor.
  int some(double low, double high) {
    return static_cast<int>(office_.options.clutter * random_.uniform(low, high));
  }

  Office& office_;
  Area area_;
  Eigen::Isometry3d T_world_area_;
  Random& random_;
  std::vector<Taken> taken_;
};

}  // namespace xview
