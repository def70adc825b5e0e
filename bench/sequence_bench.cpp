// SPDX-License-Identifier: BSD-3-Clause
// Windows alone, together with their history, and followed, of some sessions against the map of
// another one.
//
//   sequence_bench MAP_SESSION SESSION... [--window 15] [--stride 15] [--key.subkey VALUE]...
//
// Sessions as in localization_bench. Recall: accepted and within 5 m, of all windows; wrong:
// accepted and farther off, or from elsewhere.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>

#include "session.h"
#include "xview/eval/evaluation.h"
#include "xview/sequence.h"
#include "xview/tracker.h"

namespace {

using namespace xview;
using namespace xview::bench;

/// Windows that share no frame: evidence counts once.
std::vector<Window> disjointWindows(const Session& s, double window_m, double stride_m) {
  constexpr double kRounding_m = 1e-6;
  const std::vector<double>& t = s.travelled;
  std::vector<Window> windows;
  for (double from = 0; from == 0 || from + window_m <= t.back() + 1; from += stride_m) {
    const auto first = std::lower_bound(t.begin(), t.end(), from - kRounding_m) - t.begin();
    const auto last =
        std::upper_bound(t.begin(), t.end(), from + window_m - kRounding_m) - t.begin();
    windows.push_back({static_cast<std::size_t>(first), static_cast<std::size_t>(last)});
  }
  return windows;
}

struct Tally {
  int windows = 0, right = 0, wrong = 0, ambiguous = 0, local = 0, lost = 0;
  std::vector<double> errors_m, ms;
  void add(const Localization& fix, const Session& s, std::size_t last, bool show_wrong) {
    ++windows;
    ambiguous += fix.status == Status::ambiguous;
    double total = 0;
    for (const auto& [stage, t] : fix.timing_ms)
      total += stage == "total" || stage == "track" ? t : 0;
    for (const auto& [stage, t] : fix.timing_ms)
      total -= stage == "read" || stage == "lift" || stage == "blobs" ? t : 0;
    ms.push_back(total);
    if (!fix.accepted()) return;
    const double error =
        s.negative
            ? INFINITY
            : (fix.T_map_sensor.translation() - s.truth[last - 1].T_frame_sensor.translation())
                  .norm();
    if (error <= 5)
      errors_m.push_back(error), ++right;
    else
      ++wrong;
    if (show_wrong && !(error <= 5))
      fmt::print("  wrong: frames to {}, {:.1f} m off: {}\n", last - 1, error, fix.reason);
  }
};

void print(const Session& s, const char* how, const Tally& t) {
  fmt::print(
      "{:<10} {:<8} {:4} | {:5.1f} {:5} {:5} | {:6.3f} {:6.3f} | {:5} {:4} | {:7.1f} {:7.1f}\n",
      s.name, how, t.windows, 100.0 * t.right / std::max(1, t.windows), t.wrong, t.ambiguous,
      quantile(t.errors_m, .5), quantile(t.errors_m, .9), t.local, t.lost, quantile(t.ms, .5),
      quantile(t.ms, .9));
  std::fflush(stdout);
}

void run(const Session& s, const Localizer& localizer, const Options& options, double window_m,
         double stride_m) {
  Tally alone, together, followed;
  Sequence sequence(localizer, options);
  Tracker tracker(localizer, options);
  for (const Window& w : disjointWindows(s, window_m, stride_m)) {
    const Query query =
        makeQuery(s.frames.data() + w.first, s.frames.data() + w.last, s.labels, options);
    const SequenceAnswer fused = sequence.add(query, w.first, w.last);
    alone.add(fused.alone, s, w.last, false);
    together.add(fused.fix, s, w.last, true);
    const TrackAnswer track = tracker.follow(query);
    followed.add(track.fix, s, w.last, true);
    followed.local += track.local;
    followed.lost += track.lost;
  }
  print(s, "alone", alone);
  print(s, "sequence", together);
  print(s, "track", followed);
}

}  // namespace

int main(int argc, char** argv) try {
  double window_m = 15, stride_m = 15;
  Options options;
  options.threads = 1;
  const std::vector<std::string> sessions =
      parseArguments(argc, argv, {{"--window", into(window_m)}, {"--stride", into(stride_m)}},
                     options, 2, "sequence_bench MAP_SESSION SESSION... [options]");
  const auto source = io::openRecording(sessions[0]);
  const map::SemanticMap map = buildMap({source.get()}, options);
  const Localizer localizer(map, options);
  fmt::print("map {}; windows of {} m every {} m; ms: graph and search\n", sessions[0], window_m,
             stride_m);
  fmt::print(
      "session    how         n | recall wrong ambi | median    p90 | local lost |  median     p90 "
      "ms\n");
  for (std::size_t i = 1; i < sessions.size(); ++i)
    run(loadSession(sessions[i], options), localizer, options, window_m, stride_m);
  return 0;
} catch (const std::exception& e) {
  std::cerr << "error: " << e.what() << "\n";
  return 1;
}
