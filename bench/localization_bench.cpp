// SPDX-License-Identifier: BSD-3-Clause
// Success, accuracy, verdicts and times of every window of some sessions against the map of another
// one.
//
//   localization_bench MAP_SESSION SESSION... [--window 60,30,15] [--stride 10] [--drift 0.03]
//   [--key.subkey VALUE]...
//                     [--csv FILE]
//
// A session is a recording with groundtruth.txt (poses in the map frame; a folder named after
// `elsewhere` has none that counts: its windows must not be accepted). The last lines judge the
// confidence over all windows: recall where precision is 99 %, and how many answers of each
// confidence are right.
// --drift adds a smooth drift of the odometry to the sessions, of this share of the way, seeded by
// --seed. The columns under NEES/6 judge the covariance over the accepted windows within 5 m: mean
// (1 if right, less if too wide) and median (0.89 if right) of the normalised error squared over 6,
// and the share in % within three sigma of six dimensions.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "disturbance.h"
#include "session.h"
#include "xview/eval/evaluation.h"
#include "xview/localizer.h"
#include "xview/types/pose.h"

namespace {

using namespace xview;
using namespace xview::bench;

struct Arguments {
  std::vector<std::string> sessions;
  std::vector<double> windows_m = {60};
  double stride_m = 10;
  double drift = 0;
  std::string csv;
  Options options;
};

std::vector<double> numbers(const std::string& text) {
  std::vector<double> values;
  for (const std::string& word : words(text)) values.push_back(std::stod(word));
  return values;
}

Arguments parse(int argc, char** argv) {
  Arguments a;
  a.options.threads = 1;
  a.sessions =
      parseArguments(argc, argv,
                     {{"--window", [&](const std::string& value) { a.windows_m = numbers(value); }},
                      {"--stride", into(a.stride_m)},
                      {"--drift", into(a.drift)},
                      {"--csv", [&](const std::string& value) { a.csv = value; }}},
                     a.options, 2, "localization_bench MAP_SESSION SESSION... [options]");
  return a;
}

struct Tally {
  int windows = 0, accepted = 0, ambiguous = 0, wrong_accepted = 0;
  std::vector<double> errors_m, errors_deg, nees, search_ms, graph_ms;
  double within(double metres) const {
    return errors_m.empty()
               ? 0
               : 100.0 *
                     static_cast<double>(std::count_if(errors_m.begin(), errors_m.end(),
                                                       [&](double e) { return e <= metres; })) /
                     static_cast<double>(errors_m.size());
  }
};

double timing(const Localization& fix, std::initializer_list<const char*> stages) {
  double sum = 0;
  for (const auto& [name, ms] : fix.timing_ms) {
    for (const char* stage : stages) sum += name == stage ? ms : 0;
  }
  return sum;
}

/// All answers, for what they say together.
struct Answers {
  std::vector<Detection> detections;
  std::vector<double> nees;
  std::size_t positives = 0;

  void add(const Localization& fix, bool is_right, bool is_negative) {
    detections.push_back({fix.hypotheses.empty() ? -1 : fix.confidence, is_right});
    positives += !is_negative;
  }

  void print() const {
    const Consistency c = consistencyOf(nees);
    fmt::print(
        "covariance over {} accepted windows: NEES/6 mean {:.2f}, median {:.2f}, within 3 sigma "
        "{:.1f} %\n",
        c.answers, c.mean, c.median, 100 * c.within_3_sigma);
    double recall = 0;
    for (const PrecisionRecall& p : precisionRecallCurve(detections, positives)) {
      if (p.precision >= 0.99) recall = std::max(recall, p.recall);
    }
    fmt::print("recall at 99 % precision {:.2f} % of {} windows, with {} from elsewhere\n",
               100 * recall, positives, detections.size() - positives);
    constexpr double kLimits[] = {0, 0.5, 0.9, 0.99, 0.999, 2};
    for (std::size_t i = 0; i + 1 < std::size(kLimits); ++i) {
      std::size_t count = 0, right = 0;
      for (const Detection& d : detections) {
        if (d.confidence < kLimits[i] || d.confidence >= kLimits[i + 1]) continue;
        ++count;
        right += d.correct;
      }
      fmt::print("  confidence from {:5.3f}: {:5} answers, {:5} right\n", kLimits[i], count, right);
    }
  }
};

void runSession(const Session& s, double window_m, const Localizer& localizer, const Arguments& a,
                std::ofstream& csv, Answers& answers) {
  Tally tally;
  for (const auto& [first, last] : windowsOf(s, window_m, a.stride_m)) {
    const Query query =
        makeQuery(s.frames.data() + first, s.frames.data() + last, s.labels, a.options);
    const Localization fix = localizer.localize(query);
    ++tally.windows;
    tally.accepted += fix.accepted();
    tally.ambiguous += fix.status == Status::ambiguous;
    double error = NAN, turn = NAN, nees = NAN;
    if (!s.negative && !fix.hypotheses.empty()) {
      const Eigen::Isometry3d& truth = s.truth[last - 1].T_frame_sensor;
      error = (fix.T_map_sensor.translation() - truth.translation()).norm();
      turn = rotationBetween(fix.T_map_sensor, truth) * 180 / M_PI;
      nees = normalisedErrorSquared(fix.covariance, fix.T_map_sensor, truth);
    }
    if (!s.negative) {
      tally.errors_m.push_back(std::isnan(error) ? 1e9 : error);
      tally.errors_deg.push_back(std::isnan(turn) ? 180 : turn);
    }
    answers.add(fix, error <= 5, s.negative);
    tally.wrong_accepted += fix.accepted() && !(error <= 5);
    if (fix.accepted() && error <= 5) {
      tally.nees.push_back(nees);
      answers.nees.push_back(nees);
    }
    tally.search_ms.push_back(
        timing(fix, {"descriptors", "matching", "rejection", "pose", "refine"}));
    tally.graph_ms.push_back(timing(fix, {"graph"}));
    if (csv) {
      csv << fmt::format("{},{},{},{},{:.3f},{:.3f},{},{:.4f},{:.2f},{:.2f},{},{},{:.4f},\"{}\"\n",
                         s.name, window_m, first, last, error, turn, toString(fix.status),
                         fix.confidence, fix.hypotheses.empty() ? 0 : fix.hypotheses[0].score,
                         fix.hypotheses.size() > 1 ? fix.hypotheses[1].score : 0, fix.inliers,
                         fix.vertices, nees, fix.reason);
    }
  }
  const Consistency consistency = consistencyOf(tally.nees);
  fmt::print(
      "{:<10} {:4} m {:4} | {:5.1f} {:5.1f} {:5.1f} {:5.1f} {:5.1f} | {:6.3f} {:6.3f} {:6.3f} | "
      "{:4} {:4} {:5} | {:5.2f} {:5.2f} {:5.1f} | {:6.1f} {:6.1f}\n",
      s.name, window_m, tally.windows, tally.within(0.3), tally.within(0.5), tally.within(1),
      tally.within(5), tally.within(20), quantile(tally.errors_m, .5), quantile(tally.errors_m, .9),
      quantile(tally.errors_deg, .5), tally.accepted, tally.ambiguous, tally.wrong_accepted,
      consistency.mean, consistency.median, 100 * consistency.within_3_sigma,
      quantile(tally.graph_ms, .5), quantile(tally.search_ms, .5));
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) try {
  const Arguments a = parse(argc, argv);
  const auto source = io::openRecording(a.sessions[0]);
  Options parallel = a.options;
  parallel.threads = 0;
  const map::SemanticMap map = buildMap({source.get()}, parallel);
  std::ofstream csv;
  if (!a.csv.empty()) csv.open(a.csv, std::ios::app);
  const Localizer localizer(map, a.options);
  fmt::print("map {}: {} vertices, {} plan samples; a window every {} m\n", a.sessions[0],
             map.graph.size(), map.plan.sampleCount(), a.stride_m);
  fmt::print(
      "session    window    n | <=.3m <=.5m  <=1m  <=5m <=20m | median    p90    deg |  acc ambi "
      "wrong | NEES/6 med  3sig | graph  search ms\n");
  Answers answers;
  for (std::size_t i = 1; i < a.sessions.size(); ++i) {
    Session session = loadSession(a.sessions[i], a.options);
    addDrift(session, a.drift, static_cast<std::uint64_t>(a.options.seed));
    for (const double window_m : a.windows_m)
      runSession(session, window_m, localizer, a, csv, answers);
  }
  answers.print();
  return 0;
} catch (const std::exception& e) {
  std::cerr << "error: " << e.what() << "\n";
  return 1;
}
