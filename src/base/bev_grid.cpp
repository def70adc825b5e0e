// SPDX-License-Identifier: BSD-3-Clause
#include "xview/base/bev_grid.h"

#include <algorithm>
#include <utility>

#include "base/channel_moves.h"
#include "base/stored_view.h"

namespace xview {

const char* toString(BevChannel channel) {
  static constexpr const char* kNames[] = {"road",
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
  static_assert(std::size(kNames) == kBevChannels);
  return channel < BevChannel::count ? kNames[static_cast<std::size_t>(channel)] : "?";
}

const GroundCell* BevGrid::knownCell(std::int32_t x, std::int32_t y) const {
  const GroundCell wanted{x, y, 0, false};
  const auto at = std::lower_bound(known.begin(), known.end(), wanted, InRowOrder());
  return at != known.end() && at->x == x && at->y == y ? &*at : nullptr;
}

std::size_t BevGrid::sampleCount() const {
  std::size_t total = 0;
  for (const auto& channel : samples) total += channel.size();
  return total;
}

void moveSamples(const ChannelMoves& moves, BevGrid& bev) {
  for (const auto& [from, targets] : moves) {
    const std::vector<BevSample> samples = std::exchange(bev[from], {});
    for (const BevChannel to : targets) {
      bev[to].insert(bev[to].end(), samples.begin(), samples.end());
      std::sort(bev[to].begin(), bev[to].end(), InRowOrder());
    }
  }
}

void addColumns(const Eigen::AlignedBox2d& box, CellIndex& columns) {
  const auto columnOf = [](double p) { return floorToInt(p / StoredView::kColumn_m); };
  for (std::int32_t y = columnOf(box.min().y()); y <= columnOf(box.max().y()); ++y) {
    for (std::int32_t x = columnOf(box.min().x()); x <= columnOf(box.max().x()); ++x)
      columns.findOrAdd(x, y);
  }
}

BevGrid gathered(const StoredView& view, const CellIndex& columns, const BevGrid& empty) {
  BevGrid all = empty;
  const auto append = [](const auto& items, auto& to) {
    to.insert(to.end(), items.begin(), items.end());
  };
  for (const PlaneCell& column : view.columns()) {
    if (columns.find(column.x, column.y) < 0) continue;
    const std::shared_ptr<const BevGrid> part = view.partOf(column);
    for (std::size_t c = 0; c < kBevChannels; ++c) append(part->samples[c], all.samples[c]);
    append(part->known, all.known);
  }
  for (auto& samples : all.samples) std::sort(samples.begin(), samples.end(), InRowOrder());
  std::sort(all.known.begin(), all.known.end(), InRowOrder());
  return all;
}

}  // namespace xview
