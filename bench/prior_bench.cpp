// SPDX-License-Identifier: BSD-3-Clause
// What a prior does to windows of some sessions: one that is right, and ones that are not.
//
//   prior_bench MAP_SESSION SESSION... [--window 30] [--stride 30] [--radius 20]
//   [--key.subkey VALUE]...
//
// Sessions as in localization_bench. Wrong priors are circles every 40 m along the map whose middle
// is more than two radii and 20 m from the truth (any circle for sessions from elsewhere); nothing
// may be accepted there.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>

#include "session.h"
#include "xview/io/recording.h"
#include "xview/localizer.h"
#include "xview/types/pose.h"

namespace {

using namespace xview;
using namespace xview::bench;

struct Arguments {
  std::vector<std::string> sessions;
  double window_m = 30, stride_m = 30, radius_m = 20;
  Options options;
};

Arguments parse(int argc, char** argv) {
  Arguments a;
  a.options.threads = 1;
  a.sessions = parseArguments(argc, argv,
                              {{"--window", into(a.window_m)},
                               {"--stride", into(a.stride_m)},
                               {"--radius", into(a.radius_m)}},
                              a.options, 2, "prior_bench MAP_SESSION SESSION... [options]");
  return a;
}

std::vector<Eigen::Vector3d> circles(const map::SemanticMap& map) {
  std::vector<Eigen::Vector3d> middles;
  for (const Eigen::Isometry3d& T : map.poses) {
    const Eigen::Vector3d p = T.translation();
    if (middles.empty() || (p - middles.back()).norm() >= 40) middles.push_back(p);
  }
  return middles;
}

Options within(const Eigen::Vector3d& middle, const Arguments& a) {
  Options options = a.options;
  options.prior.near = fmt::format("{:.3f},{:.3f},{:.3f}", middle.x(), middle.y(), a.radius_m);
  return options;
}

/// Believes that the robot is in one circle.
struct Believer {
  Eigen::Vector3d middle;
  std::unique_ptr<Localizer> localizer;
};

struct Tally {
  int n = 0, accepted = 0, wrong = 0;
  double ms = 0;
  void add(const Localization& fix, bool is_right) {
    ++n;
    accepted += fix.accepted() && is_right;
    wrong += fix.accepted() && !is_right;
    for (const auto& [stage, t] : fix.timing_ms)
      ms += stage == "matching" || stage == "descriptors" || stage == "rejection" ? t : 0;
  }
  std::string text() const {
    return fmt::format("{:5} {:5} {:5} {:7.1f}", n, accepted, wrong, ms / std::max(1, n));
  }
};

void run(const std::string& path, const map::SemanticMap& map, const Localizer& localizer,
         const std::vector<Believer>& believers, const Arguments& a) {
  const Session session = loadSession(path, a.options);
  const std::vector<FrameDigest>& frames = session.frames;
  const std::vector<io::StampedPose>& truth = session.truth;
  Tally free, right, wrong;
  for (std::size_t first = 0; first < frames.size();) {
    double way = 0;
    std::size_t last = first + 1, next = frames.size();
    for (; last < frames.size() && way < a.window_m; ++last) {
      way +=
          (frames[last].T_odom_sensor.translation() - frames[last - 1].T_odom_sensor.translation())
              .norm();
      if (way >= a.stride_m && next == frames.size()) next = last;
    }
    if (way < a.window_m - 2) break;
    const Query query =
        makeQuery(frames.data() + first, frames.data() + last, session.labels, a.options);
    const auto isRight = [&](const Localization& fix) {
      return !session.negative &&
             (fix.T_map_sensor.translation() - truth[last - 1].T_frame_sensor.translation())
                     .norm() <= 5;
    };
    const Localization anywhere = localizer.localize(query);
    free.add(anywhere, isRight(anywhere));
    const Eigen::Vector3d here =
        session.negative ? Eigen::Vector3d(0, 0, 0)
                         : Eigen::Vector3d(truth[last - 1].T_frame_sensor.translation());
    if (!session.negative) {
      const Eigen::Vector3d beside = here + Eigen::Vector3d(0.4 * a.radius_m, 0, 0);
      const Localization fix = Localizer(map, within(beside, a)).localize(query);
      right.add(fix, isRight(fix));
    }
    for (const Believer& believer : believers) {
      if (!session.negative && (believer.middle - here).norm() < 2 * a.radius_m + 20) continue;
      wrong.add(believer.localizer->localize(query), false);
    }
    first = next;
  }
  fmt::print("{:<24} | {} | {} | {}\n", session.name, free.text(), right.text(), wrong.text());
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) try {
  const Arguments a = parse(argc, argv);
  const auto source = io::openRecording(a.sessions[0]);
  const map::SemanticMap map = buildMap({source.get()}, a.options);
  const Localizer localizer(map, a.options);
  std::vector<Believer> believers;
  for (const Eigen::Vector3d& p : circles(map))
    believers.push_back({p, std::make_unique<Localizer>(map, within(p, a))});
  fmt::print(
      "map {}; windows of {} m, circle of {} m; columns: windows, accepted right, accepted wrong, "
      "search ms\n",
      a.sessions[0], a.window_m, a.radius_m);
  fmt::print(
      "session                  | no prior                | right prior             | wrong "
      "prior\n");
  for (std::size_t i = 1; i < a.sessions.size(); ++i)
    run(a.sessions[i], map, localizer, believers, a);
  return 0;
} catch (const std::exception& e) {
  std::cerr << "error: " << e.what() << "\n";
  return 1;
}
