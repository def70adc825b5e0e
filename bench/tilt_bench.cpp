// SPDX-License-Identifier: BSD-3-Clause
// Windows of sessions, turned about random axes, against the map of another session: as frames, as
// one labelled cloud without view-points, as a bare graph (in the bare graph of the map).
//
//   tilt_bench MAP_SESSION SESSION... [--tilts 0,10,40,90,180] [--as frames,cloud,graph] [--window
//   60] [--stride 20]
//              [--scale 1] [--seed 1] [--key.subkey VALUE]...
//
// Sessions as in localization_bench. Errors are those of the place of the last sensor and of the
// rotation of the query.
// --scale makes everything in the query so many times as large as it is.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <sstream>

#include "disturbance.h"
#include "session.h"
#include "xview/eval/evaluation.h"
#include "xview/localizer.h"
#include "xview/types/pose.h"

namespace {

using namespace xview;
using namespace xview::bench;

struct Arguments {
  std::vector<std::string> sessions, representations{"frames", "cloud", "graph"},
      tilts{"0", "10", "40", "90", "180"};
  double window_m = 60, stride_m = 20, factor = 1;
  Options options;
};

/// All points of the frames as one cloud, as a saved map has them.
FrameDigest asCloud(const std::vector<FrameDigest>& frames, const LabelSet& labels,
                    const Options& options) {
  Frame one;
  one.sensor = Sensor::cloud;
  one.cloud.origin = frames[0].cloud.origin;
  for (const FrameDigest& frame : frames) {
    const Eigen::Vector3f shift = (frame.cloud.origin - one.cloud.origin).cast<float>();
    for (std::size_t i = 0; i < frame.cloud.size(); ++i) {
      if (frame.votes[i] <= 0) continue;
      Point point = frame.cloud.points[i];
      point.getVector3fMap() += shift;
      one.cloud.points.push_back(point);
    }
  }
  one.cloud = graph::thinByVoxel(one.cloud, 0.2);
  return digestFrame(std::move(one), labels, options);
}

Query queryOf(const std::string& representation, const std::vector<FrameDigest>& frames,
              const LabelSet& labels, const Options& options) {
  if (representation == "frames")
    return makeQuery(frames.data(), frames.data() + frames.size(), labels, options);
  if (representation == "cloud") {
    const FrameDigest cloud = asCloud(frames, labels, options);
    return makeQuery(&cloud, &cloud + 1, labels, options);
  }
  SemanticGraph graph =
      makeQuery(frames.data(), frames.data() + frames.size(), labels, options).graph;
  graph.setEdges({});
  return makeQuery(graph, labels, options);
}

struct Tally {
  int windows = 0, near = 0, right = 0, accepted = 0, wrong = 0, levelled = 0, free = 0;
  std::vector<double> errors_m, errors_deg, ms, scales;
};

class Bench {
 public:
  explicit Bench(const Arguments& a) : a_(a) {
    Options upright = a.options;
    upright.gravity = "auto";
    map_ = buildMap({openPart(a.sessions[0]).get()}, upright);
    bare_ = buildMap(map_.graph, map_.labels, "bare graph", upright);
    with_views_ = std::make_unique<Localizer>(map_, a.options);
    with_graph_ = std::make_unique<Localizer>(bare_, a.options);
  }

  void run(const Session& s, const std::string& representation, double tilt_deg) {
    const Localizer& localizer = representation == "graph" ? *with_graph_ : *with_views_;
    Tally tally;
    Random random(static_cast<std::uint64_t>(a_.options.seed),
                  static_cast<std::uint64_t>(tilt_deg));
    for (const auto& [first, last] : windowsOf(s, a_.window_m, a_.stride_m)) {
      Eigen::Isometry3d turn(randomTurn(tilt_deg * M_PI / 180, random));
      std::vector<FrameDigest> frames;
      for (std::size_t i = first; i < last; ++i)
        frames.push_back(scaledFrame(movedFrame(s.frames[i], turn), a_.factor));
      const Query query = queryOf(representation, frames, s.labels, a_.options);
      add(localizer.localize(query), s, last, turn, tally);
    }
    print(s, representation, tilt_deg, tally);
  }

 private:
  void add(const Localization& fix, const Session& s, std::size_t last,
           const Eigen::Isometry3d& turn, Tally& tally) const {
    ++tally.windows;
    tally.accepted += fix.accepted();
    tally.levelled += fix.gravity == GravityUse::levelled;
    tally.free += fix.gravity == GravityUse::free;
    for (const auto& [stage, ms] : fix.timing_ms) {
      if (stage == "total") tally.ms.push_back(ms);
    }
    double error = INFINITY, degrees = 180;
    if (!s.negative && !fix.hypotheses.empty()) {
      const Eigen::Isometry3d true_query = s.truth[last - 1].T_frame_sensor *
                                           s.frames[last - 1].T_odom_sensor.inverse() *
                                           turn.inverse();
      const Eigen::Vector3d sensor = turn * s.frames[last - 1].T_odom_sensor.translation();
      error = (fix.T_map_query * (fix.scale * a_.factor * sensor) - true_query * sensor).norm();
      degrees = rotationBetween(fix.T_map_query, true_query) * 180 / M_PI;
      tally.scales.push_back(fix.scale * a_.factor);
    }
    const bool right = error <= 5 && degrees <= 10;
    tally.near += error <= 1 && degrees <= 3;
    tally.right += right;
    tally.wrong += fix.accepted() && !right;
    if (!s.negative) {
      tally.errors_m.push_back(error);
      tally.errors_deg.push_back(degrees);
    }
  }

  static void print(const Session& s, const std::string& representation, double tilt_deg,
                    const Tally& t) {
    const double percent = 100.0 / std::max(1, t.windows);
    fmt::print(
        "{:<10} {:<7} {:4.0f} | {:4} {:5.1f} {:5.1f} | {:7.3f} {:6.3f} | {:4} {:5} | {:4} {:4} | "
        "{:6.3f} | {:7.1f}\n",
        s.name, representation, tilt_deg, t.windows, percent * t.near, percent * t.right,
        quantile(t.errors_m, .5), quantile(t.errors_deg, .5), t.accepted, t.wrong, t.levelled,
        t.free, quantile(t.scales, .5), quantile(t.ms, .5));
    std::fflush(stdout);
  }

  const Arguments& a_;
  map::SemanticMap map_, bare_;
  std::unique_ptr<Localizer> with_views_, with_graph_;
};

}  // namespace

int main(int argc, char** argv) try {
  Arguments a;
  a.options.threads = 1;
  a.sessions =
      parseArguments(argc, argv,
                     {{"--tilts", [&](const std::string& value) { a.tilts = words(value); }},
                      {"--as", [&](const std::string& value) { a.representations = words(value); }},
                      {"--window", into(a.window_m)},
                      {"--stride", into(a.stride_m)},
                      {"--factor", into(a.factor)}},
                     a.options, 2, "tilt_bench MAP_SESSION SESSION... [options]");
  Bench bench(a);
  fmt::print(
      "session    query   tilt |    n  <=1m  <=5m |  median    deg |  acc wrong | lev. free | "
      "scale |      ms\n");
  for (std::size_t i = 1; i < a.sessions.size(); ++i) {
    const Session session = loadSession(a.sessions[i], a.options);
    for (const std::string& representation : a.representations) {
      for (const std::string& tilt : a.tilts) bench.run(session, representation, std::stod(tilt));
    }
  }
  return 0;
} catch (const std::exception& e) {
  std::cerr << "error: " << e.what() << "\n";
  return 1;
}
