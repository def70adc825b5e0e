// SPDX-License-Identifier: BSD-3-Clause
#include "windows.h"

#include <fmt/core.h>

#include "scenes.h"
#include "xview/sequence.h"
#include "xview/types/median.h"
#include "xview/types/pose.h"

namespace xview::tools {
namespace {

constexpr double kWindow_m = 60;  ///< of a town; a place of another size has its own

/// Windows of so much way, from one start to the next half of it; the last one ends where the
/// recording does.
std::vector<Window> windowsOf(const std::vector<Eigen::Isometry3d>& poses, double length_m) {
  const std::vector<double> way = wayAlong(poses);
  std::vector<Window> windows;
  std::size_t first = 0;
  for (std::size_t last = 0; last < poses.size(); ++last) {
    const bool is_end = last + 1 == poses.size();
    if (way[last] - way[first] < length_m && !is_end) continue;
    if (is_end && !windows.empty()) {
      while (first > 0 && way[last] - way[first] < length_m) --first;
    }
    windows.push_back({first, last + 1});
    const double next_m = way[first] + length_m / 2;
    while (first < last && way[first] < next_m) ++first;
  }
  return windows;
}

}  // namespace

void forEachWindow(const QueryInput& input, const std::vector<Window>& windows, const Job& job,
                   const std::function<void(const Query&, const Window&)>& take) {
  FrameReport report(*input.source, job.narrate);
  std::vector<FrameDigest> kept;  // the last of them is the one that was read last
  auto next = windows.begin();
  digestRecording(*input.source, job.options, [&](FrameDigest frame) {
    report.add(frame);
    kept.push_back(std::move(frame));
    for (; next != windows.end() && next->last == report.added(); ++next) {
      const FrameDigest* end = kept.data() + kept.size();
      const Query query =
          makeQuery(end - (next->last - next->first), end, input.labels, job.options);
      report.pause();
      take(query, *next);
      report.resume();
    }
    const std::size_t first = next == windows.end() ? input.size() : next->first;
    const std::size_t before = report.added() - kept.size();  // frames that are kept no more
    if (first > before)
      kept.erase(kept.begin(),
                 kept.begin() + static_cast<std::ptrdiff_t>(std::min(first - before, kept.size())));
  });
  report.say();
}

PlacedRecording placeRecording(const QueryInput& input, const Localizer& localizer,
                               const Job& job) {
  PlacedRecording placed;
  placed.first = input.size();
  std::optional<Sequence> sequence;
  if (job.options.method != "walks") sequence.emplace(localizer, job.options);
  std::vector<double> sigmas;
  const std::vector<Window> windows = windowsOf(input.poses(), kWindow_m * localizer.size());
  forEachWindow(input, windows, job, [&](const Query& query, const Window& window) {
    const Localization fix =
        sequence ? sequence->add(query, window.first, window.last).fix : localizer.localize(query);
    job.narrate.detail(fmt::format("{}-{} {}: {}", input.frames[window.first].number,
                                   input.frames[window.last - 1].number, toString(fix.status),
                                   fix.reason));
    if (!fix.accepted()) {
      placed.reason = fix.reason;
      return;
    }
    placed.fixes.push_back({window.last - 1, fix.T_map_query, fix.T_map_sensor, fix.scale,
                            fix.covariance, fix.confidence});
    placed.first = std::min(placed.first, window.first);
    placed.last = std::max(placed.last, window.last);
    sigmas.push_back(verify::horizontalSigma(fix.covariance));
  });
  placed.windows = windows.size();
  if (placed.fixes.empty()) return placed;
  placed.sigma_m = medianOf(sigmas);
  const auto poses = pose::trajectoryThrough(input.poses(), placed.fixes);
  placed.T_map_sensor.assign(poses.begin() + static_cast<std::ptrdiff_t>(placed.first),
                             poses.begin() + static_cast<std::ptrdiff_t>(placed.last));
  return placed;
}

}  // namespace xview::tools
