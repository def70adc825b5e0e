// SPDX-License-Identifier: BSD-3-Clause
#include "denser_fixes.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "base/pose.h"
#include "xview/base/budget.h"
#include "xview/base/frame.h"

namespace xview::tools {
namespace {

using Fixes = std::vector<pose::TrajectoryFix>;

// Of a town: the way that finds a first frame, the windows between two fixes and how far apart
// they end, and how far off such a window may be beside the drift of the odometry.
constexpr double kFirst_m = 60, kBetween_m = 20, kSpacing_m = 10, kNear_m = 2;
constexpr double kMostDrift = 0.1;  ///< of the way
constexpr double kMostTurn_rad = 0.15;
constexpr double kFarthest_m = 20;  ///< of a town: beyond it a short window is not looked for

/// The first fix at or after a position.
Fixes::const_iterator fixFrom(const Fixes& fixes, std::size_t position) {
  return std::find_if(fixes.begin(), fixes.end(),
                      [&](const pose::TrajectoryFix& fix) { return fix.index >= position; });
}

/// The first frame of a window, which is found as the last one of its way back: the next fix is off
/// by all that odometry drifts until then. Nothing if it is not found near there.
std::optional<pose::TrajectoryFix> firstOf(const Window& window, const pose::TrajectoryFix& next,
                                           const std::vector<double>& way_m,
                                           const Eigen::Isometry3d& T_odom_first,
                                           const QueryInput& input, const Localizer& localizer,
                                           const Job& job) {
  std::vector<std::size_t> positions;
  std::vector<Eigen::Isometry3d> poses;
  for (std::size_t i = window.last; i-- > window.first;) {
    positions.push_back(i);
    poses.push_back(input.source->pose(i));
  }
  const PosedRecording back(*input.source, std::move(positions), std::move(poses));
  const Budget budget(job.limits);
  Query query;
  if (cutByBudget([&] { query = makeQuery(back, job.options); })) return std::nullopt;
  const Localization answer = localizer.localize(query);
  const Eigen::Vector3d first = T_odom_first.translation() * next.scale;
  const double off_m = (answer.T_map_sensor.translation() - next.T_map_query * first).norm();
  if (!answer.accepted() || off_m > kMostDrift * (way_m[next.index] - way_m[window.first]))
    return std::nullopt;
  pose::TrajectoryFix fix = pose::fixOf(answer, window.first);
  fix.way.clear();  // its frames run backwards
  return fix;
}

void addFirst(const QueryInput& input, const std::vector<double>& way_m, const Localizer& localizer,
              const Job& job, FoundFrames& found) {
  for (std::size_t first = 0; first < input.size(); ++first) {
    if (!found.is_found[first] || (first > 0 && found.is_found[first - 1])) continue;
    const auto next = fixFrom(found.fixes, first);
    if (next == found.fixes.end() || next->index == first) continue;
    std::size_t last = first + 1;
    while (last <= next->index && way_m[last - 1] - way_m[first] < kFirst_m * localizer.size())
      ++last;
    if (auto fix =
            firstOf({first, last}, *next, way_m, found.T_odom_sensor[first], input, localizer, job))
      found.fixes.insert(next, std::move(*fix));
  }
}

/// Short windows that end between two fixes of one stretch.
std::vector<Window> windowsBetween(const FoundFrames& found, const std::vector<double>& way_m,
                                   double size) {
  std::vector<Window> windows;
  const Fixes& fixes = found.fixes;
  for (std::size_t k = 0; k + 1 < fixes.size(); ++k) {
    double last_m = way_m[fixes[k].index];
    const double end_m = way_m[fixes[k + 1].index] - kSpacing_m / 2 * size;
    std::size_t first = fixes[k].index;  // of the stretch
    while (first > 0 && found.is_found[first] && found.is_found[first - 1]) --first;
    for (std::size_t i = fixes[k].index + 1; i < fixes[k + 1].index; ++i) {
      if (!found.is_found[i]) first = i + 1;
      if (first > i || way_m[i] - last_m < kSpacing_m * size || way_m[i] > end_m) continue;
      std::size_t begin = i;
      while (begin > first && way_m[i] - way_m[begin] < kBetween_m * size) --begin;
      windows.push_back({begin, i + 1});
      last_m = way_m[i];
    }
  }
  return windows;
}

/// Looks for short windows near where odometry and fixes put their last frames.
void addNear(const std::vector<Window>& windows, const QueryInput& input,
             const std::vector<double>& way_m, const Localizer& localizer, const Job& job,
             FoundFrames& found) {
  if (windows.empty()) return;
  const std::vector<Eigen::Isometry3d>& T_odom_sensor = found.T_odom_sensor;
  forEachWindow(input, windows, job, [&](const Query& query, const Window& window) {
    const std::size_t i = window.last - 1;
    const auto next = fixFrom(found.fixes, i);
    double away_m = way_m[i] - way_m[(next - 1)->index];
    if (next != found.fixes.end()) away_m = std::min(away_m, way_m[next->index] - way_m[i]);
    const double radius_m = kNear_m * localizer.size() + kMostDrift * away_m;
    if (radius_m > kFarthest_m * localizer.size()) return;
    const Eigen::Isometry3d T = pose::trajectoryThrough(T_odom_sensor, found.fixes)[i];
    const Localization answer =
        localizer.localize(query, {T * T_odom_sensor[i].inverse(), radius_m, kMostTurn_rad});
    if (!answer.accepted()) return;
    found.standAt(query, i);
    found.fixes.insert(next, pose::fixOf(answer, i));
  });
}

/// The window that ends with the last frame, if none was found that does.
std::vector<Window> windowAtEnd(const FoundFrames& found, const std::vector<double>& way_m,
                                double size) {
  if (found.fixes.empty() || found.fixes.back().index + 1 >= way_m.size()) return {};
  std::size_t first = way_m.size() - 1;
  while (first > 0 && way_m.back() - way_m[first] < kBetween_m * size) --first;
  return {{first, way_m.size()}};
}

}  // namespace

void FoundFrames::standAt(const Query& query, std::size_t last) {
  const std::size_t count = std::min(query.poses.size(), last + 1);
  std::copy(query.poses.end() - static_cast<std::ptrdiff_t>(count), query.poses.end(),
            T_odom_sensor.begin() + static_cast<std::ptrdiff_t>(last + 1 - count));
}

void FoundFrames::take(const Query& query, std::size_t last) {
  standAt(query, last);
  for (std::size_t i = last + 1 - std::min(query.poses.size(), last + 1); i <= last; ++i)
    is_found[i] = true;
}

void addFixes(const QueryInput& input, const Localizer& localizer, const Job& job,
              FoundFrames& found) {
  Job silent = job;
  silent.narrate = Narrative(Verbosity::quiet);
  const std::vector<double> way_m = pathLengths(found.T_odom_sensor);
  const std::size_t before = found.fixes.size();
  addFirst(input, way_m, localizer, silent, found);
  addNear(windowAtEnd(found, way_m, localizer.size()), input, way_m, localizer, silent, found);
  addNear(windowsBetween(found, way_m, localizer.size()), input, way_m, localizer, silent, found);
  job.narrate.detail(fmt::format("{}: {} fixes were added to {}", input.path,
                                 found.fixes.size() - before, before));
}

}  // namespace xview::tools
