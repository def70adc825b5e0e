// SPDX-License-Identifier: BSD-3-Clause
// Graphs of windows of sessions, as bare graphs, in the bare graph of another session.
//
//   bare_graph_bench MAP_SESSION SESSION... [--elsewhere FOLDER,...] [--window 60,30] [--stride 15]
//                    [--csv FILE] [--key.subkey VALUE]...
//
// Sessions as in localization_bench. Those of --elsewhere are of other towns and must be refused.
// Errors are those of the place of the last sensor.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <sstream>

#include "../src/pipeline/object_evidence.h"
#include "session.h"
#include "xview/eval/evaluation.h"
#include "xview/localizer.h"
#include "xview/search/search.h"
#include "xview/types/stopwatch.h"

namespace {

using namespace xview;
using namespace xview::bench;

constexpr double kSuccess_m = 5;

struct Arguments {
  std::vector<std::string> sessions, elsewhere, windows{"60"};
  double stride_m = 15;
  std::string csv;
  Options options;
};

SemanticGraph bareGraph(const Session& s, const Window& window, const Options& options) {
  SemanticGraph graph =
      makeQuery(s.frames.data() + window.first, s.frames.data() + window.last, s.labels, options)
          .graph;
  graph.setEdges({});
  return graph;
}

struct Tally {
  int windows = 0, near = 0, right = 0, accepted = 0, wrong = 0;
  std::vector<double> errors_m, ms, vertices;
};

class Bench {
 public:
  explicit Bench(const Arguments& a)
      : a_(a),
        map_(buildMap({openPart(a.sessions[0]).get()}, a.options)),
        field_(search::makeObjectField(map_.graph, map_.labels, a.options.places)) {
    fmt::print("{}: {} vertices\n", a.sessions[0], field_->size());
  }

  void run(const std::string& word, bool is_elsewhere) {
    Session session = loadSession(word, a_.options);
    session.negative = session.negative || is_elsewhere;
    for (const std::string& window_m : a_.windows) run(session, word, window_m);
  }

 private:
  void run(const Session& s, const std::string& word, const std::string& window_m) {
    Tally tally;
    for (const Window& window : windowsOf(s, std::stod(window_m), a_.stride_m))
      ask(s, window, word + " " + window_m, tally);
    const double percent = 100.0 / std::max(1, tally.windows);
    fmt::print("{:<32} {:>3} m | {:4} {:5.1f} {:5.1f} | {:7.3f} | {:5} {:5} | {:5.0f} {:7.1f}\n",
               word.substr(word.size() - std::min<std::size_t>(32, word.size())), window_m,
               tally.windows, percent * tally.near, percent * tally.right,
               quantile(tally.errors_m, .5), tally.accepted, tally.wrong,
               quantile(tally.vertices, .5), quantile(tally.ms, .5));
    std::fflush(stdout);
  }

  void ask(const Session& s, const Window& window, const std::string& name, Tally& tally) const {
    const SemanticGraph graph = bareGraph(s, window, a_.options);
    const FrameDigest& last = s.frames[window.last - 1];
    const Eigen::Vector3d focus = last.T_odom_sensor.translation();
    Stopwatch watch;
    const search::SearchResult result =
        search::search(*field_->prepare({nullptr, &graph, {}, focus}), {}, a_.options.places, 1);
    tally.ms.push_back(watch.lap_ms());
    const ObjectEvidence evidence = evidenceOf(result);
    const Verdict verdict = judge(evidence, a_.options.object_verdict);
    double error = INFINITY;
    if (!s.negative && !result.places.empty()) {
      const Eigen::Vector3d truth = s.truth[window.last - 1].T_frame_sensor.translation();
      error = (result.places[0].T_map_query * focus - truth).norm();
      tally.errors_m.push_back(error);
    }
    const bool accepted = verdict.status == Status::accepted;
    ++tally.windows;
    tally.near += error <= 1;
    tally.right += error <= kSuccess_m;
    tally.accepted += accepted;
    tally.wrong += accepted && !(error <= kSuccess_m);
    tally.vertices.push_back(static_cast<double>(result.vertices));
    write(name, s.negative, error, evidence, verdict);
  }

  void write(const std::string& name, bool is_negative, double error, const ObjectEvidence& e,
             const Verdict& verdict) const {
    if (a_.csv.empty()) return;
    std::ofstream file(a_.csv, std::ios::app);
    file << fmt::format(
        "{} {},{},{:.2f},{:.2f},{:.2f},{:.2f},{:.3f},{},{:.2f},{:.2f},{},{:.4f},{}\n",
        a_.sessions[0], name, is_negative ? 1 : 0, std::min(error, 1e6), e.score, e.runner_up,
        e.expected, e.known_share, e.vertices, e.typical_wrong, e.wrong_deviation, e.wrong_places,
        verdict.confidence, verdict.status == Status::accepted ? 1 : 0);
  }

  const Arguments& a_;
  map::SemanticMap map_;
  std::unique_ptr<const search::Field> field_;
};

}  // namespace

int main(int argc, char** argv) try {
  Arguments a;
  a.options.threads = 1;
  a.sessions = parseArguments(
      argc, argv,
      {{"--elsewhere", [&](const std::string& value) { a.elsewhere = words(value); }},
       {"--window", [&](const std::string& value) { a.windows = words(value); }},
       {"--stride", into(a.stride_m)},
       {"--csv", [&](const std::string& value) { a.csv = value; }}},
      a.options, 1, "bare_graph_bench MAP_SESSION SESSION... [options]");
  Bench bench(a);
  fmt::print(
      "session                           window |    n  <=1m  <=5m |  median |   acc wrong | "
      "verts      ms\n");
  for (std::size_t i = 1; i < a.sessions.size(); ++i) bench.run(a.sessions[i], false);
  for (const std::string& word : a.elsewhere) bench.run(word, true);
  return 0;
} catch (const std::exception& e) {
  std::cerr << "error: " << e.what() << "\n";
  return 1;
}
