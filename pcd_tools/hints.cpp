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

/// Whoever swaps QUERY and MAP looks for a place in a part of it.
std::optional<std::string> hintOfArea(const QueryInput& refused, const map::SemanticMap& map) {
  constexpr std::size_t kTimes = 4;
  const std::size_t shown = refused.whole->bev.known.size(), known = map.bev.known.size();
  if (known == 0 || shown < kTimes * known) return std::nullopt;
  return fmt::format("{} shows {} times the area of the map; are QUERY and MAP swapped?",
                     refused.path, shown / known);
}

/// The odometry of a robot that was carried holds for what came after that.
std::optional<std::string> hintOfWindow(const QueryInput& refused, const Localizer& localizer,
                                        const Job& silent) {
  constexpr std::size_t kFewest = 9, kParts = 3;
  const std::size_t size = refused.size(), part = size / kParts;
  if (!refused.source || size < kFewest) return std::nullopt;
  bool is_found = false;
  forEachWindow(refused, {{size - part, size}}, silent, [&](const Query& query, const Window&) {
    is_found = localizer.localize(query).accepted();
  });
  if (!is_found) return std::nullopt;
  return fmt::format(
      "{}: its last {} frames are found by themselves; --window {} answers for each "
      "so many frames",
      refused.path, part, part);
}

}  // namespace

std::optional<std::string> hintFor(const QueryInput& refused, const InputFlags& input,
                                   const map::SemanticMap& map, const Localizer& localizer,
                                   const Job& job) {
  Job silent = job;
  silent.narrate = Narrative(Verbosity::quiet);
  if (const auto hint = hintOfWindow(refused, localizer, silent)) return hint;
  const bool is_one_cloud =
      refused.source && refused.source->sensor() == Sensor::cloud && refused.size() == 1;
  if (!is_one_cloud || refused.whole->cloud.empty()) return hintOfArea(refused, map);
  for (const Oddity& oddity : odditiesOf(refused.whole->cloud)) {
    io::InputOptions options = input.parsed();
    options.moved = Eigen::Affine3d(oddity.of_query);
    const QueryInput other =
        readQuery(refused.path, InputFlags(std::move(options)), silent, localizer.labels());
    if (!localizer.localize(*other.whole).accepted()) continue;
    return fmt::format("{}: it is found if {}: {}", refused.path, oddity.name,
                       howToMove(oddity.remedy));
  }
  return hintOfArea(refused, map);
}

}  // namespace xview::tools
