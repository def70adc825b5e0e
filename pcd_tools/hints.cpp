// SPDX-License-Identifier: BSD-3-Clause
#include "hints.h"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "base/median.h"
#include "place/depth_plausibility.h"

namespace xview::tools {
namespace {

constexpr double kFoot_m = 0.3048;

/// What may be unusual about a cloud or its map.
struct Oddity {
  std::string name;
  Eigen::Matrix3d of_query;  ///< what brings the cloud into its map
  Eigen::Matrix3d remedy;    ///< what makes the cloud, or the map, usual
};

/// What a cloud may be, the likeliest first.
std::vector<Oddity> odditiesOf(const LabelledCloud& cloud) {
  std::vector<Oddity> oddities;
  int axis = 2;  // along which most of the points reach least: of places it is up
  middleReach(cloud).minCoeff(&axis);
  for (const int sign : {1, -1}) {
    if (axis == 2) break;
    const Eigen::Matrix3d upright = turnUpright(axis, sign);
    oddities.push_back(
        {fmt::format("{}{} is up", sign < 0 ? "-" : "", "xy"[axis]), upright, upright});
  }
  const Eigen::Matrix3d feet = kFoot_m * Eigen::Matrix3d::Identity();
  oddities.push_back({"its lengths are feet", feet, feet});
  oddities.push_back({"the lengths of MAP are feet", feet.inverse(), feet});
  return oddities;
}

}  // namespace

std::optional<std::string> hintFor(const QueryInput& refused, const InputFlags& input,
                                   const Localizer& localizer, const Job& job) {
  const bool is_one_cloud =
      refused.source && refused.source->sensor() == Sensor::cloud && refused.size() == 1;
  if (!is_one_cloud || refused.whole->cloud.empty()) return std::nullopt;
  Job silent = job;
  silent.narrate = Narrative(Verbosity::quiet);
  for (const Oddity& oddity : odditiesOf(refused.whole->cloud)) {
    io::InputOptions options = input.parsed();
    options.moved = Eigen::Affine3d(oddity.of_query);
    const QueryInput other =
        readQuery(refused.path, InputFlags(std::move(options)), silent, localizer.labels());
    if (!localizer.localize(*other.whole).accepted()) continue;
    return fmt::format("{}: it is found if {}: {}", refused.path, oddity.name,
                       howToMove(oddity.remedy));
  }
  return std::nullopt;
}

}  // namespace xview::tools
