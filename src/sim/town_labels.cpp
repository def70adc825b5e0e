// SPDX-License-Identifier: BSD-3-Clause
#include "xview/sim/town_labels.h"

namespace xview {

LabelSet townLabels() {
  using namespace town_class;
  LabelSet set("town");
  const auto add = [&](std::uint16_t id, const char* name, std::array<std::uint8_t, 3> color,
                       Role role, Kind kind) {
    set.add({id, name, color, role, kind, false});
  };
  add(kVoid, "void", {0, 0, 0}, Role::ignored, Kind::none);
  add(kSky, "sky", {128, 128, 128}, Role::ignored, Kind::none);
  add(kBuilding, "building", {128, 0, 0}, Role::surface, Kind::building);
  add(kRoad, "road", {128, 64, 128}, Role::surface, Kind::road);
  add(kSidewalk, "sidewalk", {0, 0, 192}, Role::surface, Kind::sidewalk);
  add(kFence, "fence", {64, 64, 128}, Role::surface, Kind::fence);
  add(kVegetation, "vegetation", {128, 128, 0}, Role::surface, Kind::vegetation);
  add(kPole, "pole", {192, 192, 128}, Role::object, Kind::pole);
  add(kCar, "car", {64, 0, 128}, Role::dynamic, Kind::vehicle);
  add(kTrafficSign, "traffic sign", {192, 128, 128}, Role::object, Kind::sign);
  add(kPedestrian, "pedestrian", {64, 64, 0}, Role::dynamic, Kind::none);
  add(kBicycle, "bicycle", {0, 128, 192}, Role::dynamic, Kind::none);
  add(kLaneMarking, "lane marking", {0, 172, 0}, Role::surface, Kind::lane_marking);
  add(kTrafficLight, "traffic light", {0, 128, 128}, Role::object, Kind::light);
  add(kTerrain, "terrain", {152, 251, 152}, Role::surface, Kind::terrain);
  return set;
}

}  // namespace xview
