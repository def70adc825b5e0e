// SPDX-License-Identifier: BSD-3-Clause
#include "placed_visit.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "answer_table.h"
#include "base/median.h"
#include "base/pose.h"
#include "classes.h"
#include "denser_fixes.h"
#include "pose/trajectory.h"
#include "verdict/verdict.h"
#include "xview/base/budget.h"
#include "xview/base/frame.h"
#include "xview/base/localization.h"
#include "xview/mapper.h"
#include "xview/sequence.h"

namespace xview::tools {
namespace {

constexpr double kOneFrame_m = 1, kWindow_m = 60;  ///< of a town

/// Windows of this path length, which overlap by half; the last one ends where the
/// recording does.
std::vector<Window> windowsOf(const std::vector<double>& way_m, double length_m) {
  std::vector<Window> windows;
  std::size_t first = 0;
  for (std::size_t last = 0; last < way_m.size(); ++last) {
    const bool is_end = last + 1 == way_m.size();
    if (way_m[last] - way_m[first] < length_m && !is_end) continue;
    if (is_end && !windows.empty()) {
      while (first > 0 && way_m[last] - way_m[first] < length_m) --first;
    }
    windows.push_back({first, last + 1});
    const double next_m = way_m[first] + length_m / 2;
    while (first < last && way_m[first] < next_m) ++first;
  }
  return windows;
}

/// Says which frames are left out, and how much way they are.
void logLeftOut(const QueryInput& input, const std::vector<double>& way_m,
                const std::vector<bool>& is_found, const Narrative& narrate) {
  constexpr std::size_t kMost = 4;
  std::vector<std::string> gaps;
  double left_out_m = 0;
  std::size_t frames = 0;
  for (std::size_t i = 0; i < is_found.size();) {
    std::size_t end = i;
    while (end < is_found.size() && !is_found[end]) ++end;
    if (end > i) {
      frames += end - i;
      left_out_m += way_m[end - 1] - way_m[i];
      gaps.push_back(fmt::format("{}-{}", input.source->number(i), input.source->number(end - 1)));
    }
    i = end + 1;
  }
  if (gaps.empty()) return;
  const bool more = gaps.size() > kMost;
  if (more) gaps.resize(kMost);
  narrate.note(fmt::format(
      "{}: {} of its {} frames, {:.0f} m, are left out, where it was not "
      "found or odometry does not tell where: {}{}",
      input.path, frames, is_found.size(), left_out_m, fmt::join(gaps, ", "), more ? ", ..." : ""));
}

/// The windows of a recording that are accepted.
struct FoundWindows : FoundFrames {
  using FoundFrames::FoundFrames;
  std::vector<double> sigmas_m;
  std::set<std::size_t> jumps;  ///< positions of the frames behind them
  std::size_t asked = 0;
  double confidence = 1;  ///< the least
  std::string refusal;    ///< of the last one that was not accepted
};

FoundWindows findWindows(const QueryInput& input, const std::vector<double>& way_m,
                         const Localizer& localizer, const Job& job) {
  std::optional<Sequence> sequence;
  if (localizer.scoresPoses()) sequence.emplace(localizer, job.options);
  FoundWindows found(input.poses());
  const std::vector<Window> windows = windowsOf(way_m, kWindow_m * localizer.size());
  found.asked = windows.size();
  forEachWindow(input, windows, job, [&](const Query& query, const Window& window) {
    const Localization fix =
        sequence ? sequence->add(query, window.first, window.last).fix : localizer.localize(query);
    job.narrate.detail(fmt::format("{}-{} {}: {}", input.source->number(window.first),
                                   input.source->number(window.last - 1), toString(fix.status),
                                   fix.reason));
    for (const OdometryJump& jump : query.jumps) found.jumps.insert(window.first + jump.position);
    if (!fix.accepted()) return void(found.refusal = fix.reason);
    found.fixes.push_back(pose::fixOf(fix, window.last - 1));
    found.sigmas_m.push_back(verdict::horizontalSigma(fix.covariance));
    found.confidence = std::min(found.confidence, fix.confidence);
    found.take(query, window.last - 1);
  });
  return found;
}

std::optional<PlacedVisit> placeRecording(const QueryInput& input, const Localizer& localizer,
                                          const Job& job, std::string& refusal) {
  const std::vector<double> way_m = pathLengths(input.poses());
  FoundWindows found = findWindows(input, way_m, localizer, job);
  const std::vector<Eigen::Isometry3d>& T_odom_sensor = found.T_odom_sensor;
  if (found.fixes.empty()) {
    refusal = found.refusal;
    return std::nullopt;
  }
  for (const std::size_t jump : found.jumps)
    job.narrate.note(
        fmt::format("{}: the scans contradict its odometry at frame {}; what is before "
                    "and behind it is placed by itself",
                    input.path, input.source->number(jump)));
  PlacedVisit visit;
  visit.sigma_m = medianOf(found.sigmas_m);
  visit.confidence = found.confidence;
  visit.how = fmt::format("{}: {} of {} stretches accepted, ±{}", input.path, found.sigmas_m.size(),
                          found.asked, lengthText(visit.sigma_m));
  addFixes(input, localizer, job, found);
  const auto all =
      pose::trajectoryThrough(T_odom_sensor, found.fixes, {found.jumps.begin(), found.jumps.end()});
  const std::vector<bool> is_told =
      pose::toldByOdometry(found.fixes, T_odom_sensor, way_m, localizer.size());
  std::vector<std::size_t> kept;
  std::vector<Eigen::Isometry3d> T_map_frame;  // as the recording has its points
  for (std::size_t i = 0; i < all.size(); ++i) {
    found.is_found[i] = found.is_found[i] && all[i] && is_told[i];
    if (!found.is_found[i]) continue;
    kept.push_back(i);
    visit.poses.push_back(*all[i]);
    T_map_frame.push_back(*all[i] * T_odom_sensor[i].inverse() * input.source->pose(i));
  }
  if (kept.empty()) {
    refusal =
        "the odometry errs by more than 5 % of the way from one place where it was found to the "
        "next";
    return std::nullopt;
  }
  visit.T_map_input = visit.poses.front() * T_odom_sensor[kept.front()].inverse();
  logLeftOut(input, way_m, found.is_found, job.narrate);
  Job of_placed = job;
  of_placed.options.odometry.check = false;  // its poses are those of the map
  const auto placed = inClassesOfMap(
      std::make_unique<PosedRecording>(*input.source, std::move(kept), std::move(T_map_frame)),
      input.options);
  visit.place = mapOfRecordings({placed.get()}, of_placed, RecordingsUse::addition);
  return visit;
}

std::optional<PlacedVisit> placeWhole(QueryInput& input, const Localizer& localizer, const Job& job,
                                      std::string& refusal) {
  const Budget budget(job.limits);
  const Localization fix = localizer.localize(*input.whole);
  if (!fix.accepted()) {
    refusal = fix.reason;
    return std::nullopt;
  }
  PlacedVisit visit;
  static_cast<Place&>(visit.place) = inClassesOfMap(std::move(*input.whole), input.options);
  visit.is_whole = true;
  visit.T_map_visit = visit.T_map_input = fix.T_map_query;
  visit.sigma_m = verdict::horizontalSigma(fix.covariance);
  visit.confidence = fix.confidence;
  for (const Eigen::Isometry3d& T : visit.place.poses) visit.poses.push_back(fix.T_map_query * T);
  const Eigen::Isometry3d& last = visit.place.poses.back();
  const double off_m = (visit.poses.back().translation() - last.translation()).norm();
  const double off_deg = Eigen::AngleAxisd(fix.T_map_query.linear()).angle() * 180 / M_PI;
  visit.how = off_m < kOneFrame_m * visit.place.size
                  ? fmt::format("{} is in the frame of the map but for {} and {:.2f}°", input.path,
                                lengthText(off_m), off_deg)
                  : fmt::format("{} is brought to the frame of the map: {:.1f} m, {:.1f}°",
                                input.path, off_m, off_deg);
  return visit;
}

}  // namespace

std::optional<PlacedVisit> placeVisit(QueryInput& input, const Localizer& localizer, const Job& job,
                                      std::string& refusal) {
  return input.source ? placeRecording(input, localizer, job, refusal)
                      : placeWhole(input, localizer, job, refusal);
}

map::Visit additionOf(const PlacedVisit& placed, const QueryInput& input, const InputFlags& flags,
                      const map::SemanticMap& map, const Job& job) {
  if (!placed.is_whole) return {placed.place, placed.sigma_m};
  return {inFrameOf(map, mapOf(input.path, inputIn(flags, map.labels), job), placed.T_map_visit),
          placed.sigma_m};
}

}  // namespace xview::tools
