// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "xview/types/labels.h"

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
constexpr std::uint16_t kTrafficLight = 15;
constexpr std::uint16_t kTerrain = 16;
constexpr std::uint16_t kCount = 17;
}  // namespace town_class

/// Their names, colours and roles.
LabelSet townLabels();

}  // namespace xview
