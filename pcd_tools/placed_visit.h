// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "inputs.h"
#include "xview/map/semantic_map.h"

namespace xview::tools {

/// What was seen on a visit, and where it lies in the map that it was found in.
struct PlacedVisit {
  map::SemanticMap place;
  Eigen::Isometry3d T_map_visit = Eigen::Isometry3d::Identity();  ///< for `place`
  /// For the frame of the input, at the first frame that was found: odometry drifts behind it.
  Eigen::Isometry3d T_map_input = Eigen::Isometry3d::Identity();
  std::vector<Eigen::Isometry3d> poses;  ///< T_map_sensor
  double sigma_m = 0;                    ///< standard deviation of a pose, horizontally
  double confidence = 1;                 ///< of the stretch that is the least sure
  std::string how;                       ///< one line about how it was found
  bool is_whole = false;                 ///< a map or a graph; `place` is then a query only
};

/// Finds a visit in a map, by windows of some 60 m of a town that overlap by half and speak
/// together. The odometry is bent through the accepted ones, because it drifts; frames of none of
/// them are left out, which is said. Maps and graphs are found as a whole. Nothing if no window is
/// accepted, with the reason of the last one in `refusal`. Throws Error.
std::optional<PlacedVisit> placeVisit(QueryInput& input, const Localizer& localizer, const Job& job,
                                      std::string& refusal);

/// What the visit adds to the map, in its frame. Throws Error.
map::Visit additionOf(const PlacedVisit& placed, const QueryInput& input, const InputFlags& flags,
                      const map::SemanticMap& map, const Job& job);

}  // namespace xview::tools
