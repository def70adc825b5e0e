// SPDX-License-Identifier: BSD-3-Clause
#include "doubts.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <tuple>

namespace xview::tools {
namespace {

using Poses = std::vector<Eigen::Isometry3d>;

std::string nameOf(const map::SemanticMap& map) {
  return map.sources.empty() ? "the addition" : map.sources.front();
}

/// Class and place to the millimetre.
using Spot = std::tuple<std::uint32_t, long long, long long, long long>;
std::set<Spot> spotsOf(const SemanticGraph& graph) {
  std::set<Spot> spots;
  for (const Vertex& v : graph.vertices) {
    const auto mm = [&](int axis) { return std::llround(1e3 * v.position[axis]); };
    spots.emplace(v.label, mm(0), mm(1), mm(2));
  }
  return spots;
}

/// So much of the things stands in the other graph, to the millimetre.
bool areSameThings(const SemanticGraph& addition, const SemanticGraph& map, double share) {
  const std::set<Spot> added = spotsOf(addition), there = spotsOf(map);
  const auto common = std::count_if(added.begin(), added.end(),
                                    [&](const Spot& spot) { return there.count(spot) > 0; });
  return added.size() >= 3 &&
         static_cast<double>(common) >= share * static_cast<double>(added.size());
}

bool isInAlready(const map::SemanticMap& map, const map::SemanticMap& addition) {
  constexpr double kExact_m = 1e-3, kFused_m = 0.5;
  if (addition.poses.empty()) return areSameThings(addition.graph, map.graph, 0.9);
  const bool same_name =
      std::any_of(addition.sources.begin(), addition.sources.end(), [&](const std::string& source) {
        return std::find(map.sources.begin(), map.sources.end(), source) != map.sources.end();
      });
  if (same_name) return areSamePoses(addition.poses, map.poses, kFused_m);
  return areSamePoses(addition.poses, map.poses, kExact_m) &&
         areSameThings(addition.graph, map.graph, 0.5);
}

/// Of the walls of one view where the other one has seen something, the share that has a wall of
/// the other one beside it; nothing if there are too few to tell.
std::optional<double> wallAgreement(const PlanView& a, const PlanView& b) {
  constexpr double kNear_m = 1.5;
  constexpr std::size_t kFewest = 40;
  using Cell = std::pair<long long, long long>;
  const auto cellOf = [](double x, double y) {
    return Cell{std::llround(x / kNear_m), std::llround(y / kNear_m)};
  };
  std::set<Cell> seen, walls;
  for (const GroundCell& cell : b.known)
    seen.insert(
        cellOf(b.origin_x + (cell.x + 0.5) * b.cell_m, b.origin_y + (cell.y + 0.5) * b.cell_m));
  for (const PlanSample& s : b[Channel::building])
    walls.insert(cellOf(b.origin_x + s.x, b.origin_y + s.y));
  const auto around = [](const std::set<Cell>& cells, const Cell& c) {
    for (long long dy = -1; dy <= 1; ++dy) {
      for (long long dx = -1; dx <= 1; ++dx) {
        if (cells.count({c.first + dx, c.second + dy}) > 0) return true;
      }
    }
    return false;
  };
  std::size_t both = 0, agree = 0;
  for (const PlanSample& s : a[Channel::building]) {
    const Cell cell = cellOf(a.origin_x + s.x, a.origin_y + s.y);
    if (seen.count(cell) == 0) continue;
    ++both;
    agree += around(walls, cell);
  }
  if (both < kFewest || walls.size() < kFewest) return std::nullopt;
  return static_cast<double>(agree) / static_cast<double>(both);
}

}  // namespace

bool areSamePoses(const Poses& poses, const Poses& others, double tolerance_m) {
  const auto has_partner = [&](const Eigen::Isometry3d& a) {
    return std::any_of(others.begin(), others.end(), [&](const Eigen::Isometry3d& b) {
      return (a.translation() - b.translation()).norm() <= tolerance_m;
    });
  };
  const auto common = std::count_if(poses.begin(), poses.end(), has_partner);
  return !poses.empty() && 2 * static_cast<std::size_t>(common) > poses.size();
}

void sayDoubts(const map::SemanticMap& map, const map::SemanticMap& addition,
               const Narrative& narrate) {
  if (isInAlready(map, addition)) {
    return narrate.note(nameOf(addition) +
                        " is in the map already; adding it once more counts the same things twice "
                        "and shows nothing new");
  }
  sayIfApart({"the map", nameOf(addition)}, {map.poses, addition.poses}, narrate);
  const auto agreement = wallAgreement(addition.plan, map.plan);
  constexpr double kFits = 0.35;
  if (agreement && *agreement < kFits) {
    narrate.note(
        fmt::format("{} does not fit the map: of its walls where both have seen something "
                    "only {:.0f} % are walls of the map; are they in one frame?",
                    nameOf(addition), 100 * *agreement));
  }
}

void sayIfApart(const std::vector<std::string>& names, const std::vector<Poses>& ways,
                const Narrative& narrate) {
  constexpr double kApart_m = 500;
  for (std::size_t i = 1; i < ways.size(); ++i) {
    double nearest_m = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < i; ++j) {
      for (const Eigen::Isometry3d& a : ways[i]) {
        for (const Eigen::Isometry3d& b : ways[j])
          nearest_m = std::min(nearest_m, (a.translation() - b.translation()).norm());
      }
    }
    if (nearest_m > kApart_m && std::isfinite(nearest_m)) {
      narrate.note(fmt::format("{} is {:.0f} m away from {}; are they in one frame?", names[i],
                               nearest_m, i == 1 ? names[0] : "all others"));
    }
  }
}

}  // namespace xview::tools
