// SPDX-License-Identifier: BSD-3-Clause
#include "xview/types/bev_grid.h"

namespace xview {

const char* toString(BevChannel channel) {
  static constexpr std::array<const char*, kBevChannels> kNames = {"road",
                                                                   "sidewalk",
                                                                   "terrain",
                                                                   "lane_marking",
                                                                   "building",
                                                                   "wall_foot",
                                                                   "fence",
                                                                   "low_vegetation",
                                                                   "canopy",
                                                                   "vehicle_surface",
                                                                   "other_surface",
                                                                   "border_road_sidewalk",
                                                                   "border_sidewalk_terrain",
                                                                   "border_road_terrain",
                                                                   "obstacle_low",
                                                                   "obstacle_high",
                                                                   "pole",
                                                                   "sign",
                                                                   "light",
                                                                   "pole_like",
                                                                   "vehicle",
                                                                   "tree",
                                                                   "trunk",
                                                                   "other_object"};
  return channel < BevChannel::count ? kNames[static_cast<std::size_t>(channel)] : "?";
}

const GroundCell* BevGrid::knownCell(std::int32_t x, std::int32_t y) const {
  GroundCell wanted;
  wanted.x = x;
  wanted.y = y;
  const auto at = std::lower_bound(known.begin(), known.end(), wanted, InRowOrder());
  return at != known.end() && at->x == x && at->y == y ? &*at : nullptr;
}

std::size_t BevGrid::sampleCount() const {
  std::size_t total = 0;
  for (const auto& channel : samples) total += channel.size();
  return total;
}

}  // namespace xview
