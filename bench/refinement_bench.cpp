// SPDX-License-Identifier: BSD-3-Clause
// What each stage after the place search does to the pose of every window, and whether it ever does
// harm.
//
//   refinement_bench MAP_SESSION SESSION... [--window 60] [--stride 10] [--walks yes] [--key.subkey
//   VALUE]...
//
// Errors are those of the 3-D position of the last camera of windows that the search places within
// 5 m; `walks` (on demand) answers for all windows by the paper's method alone, unrefined.
// `harmed`: windows whose pose became worse and is more than a metre off.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "session.h"
#include "xview/eval/evaluation.h"
#include "xview/localizer.h"

namespace {

using namespace xview;
using namespace xview::bench;

constexpr double kSamePlace_m = 5;
constexpr double kHarm_m = 1;

struct Arguments {
  std::vector<std::string> sessions;
  double window_m = 60, stride_m = 10;
  bool walks = false;
  Options options;
};

Arguments parse(int argc, char** argv) {
  Arguments a;
  a.options.threads = 1;
  a.sessions =
      parseArguments(argc, argv,
                     {{"--window", into(a.window_m)},
                      {"--stride", into(a.stride_m)},
                      {"--walks", [&](const std::string& value) { a.walks = value == "yes"; }}},
                     a.options, 2, "refinement_bench MAP_SESSION SESSION... [options]");
  return a;
}

Options withStages(Options options, bool posterior, bool refinement) {
  options.posterior.enabled = posterior;
  options.refine.enabled = refinement;
  return options;
}

Options walksAlone(Options options) {
  options.method = "walks";
  return withStages(options, false, false);
}

struct Stage {
  std::string name;
  std::vector<double> errors_m, ms;
  int harmed = 0;

  void add(double error_m, double before_m) {
    errors_m.push_back(error_m);
    harmed += error_m > before_m && error_m > kHarm_m;
  }
  void print() const {
    fmt::print("  {:<14} {:4} | {:6.3f} {:6.3f} | {:5.1f} {:5.1f} {:5.1f} | {:4} | {:6.1f}\n", name,
               errors_m.size(), quantile(errors_m, .5), quantile(errors_m, .9),
               100 * shareWithin(errors_m, .3, errors_m.size()),
               100 * shareWithin(errors_m, .5, errors_m.size()),
               100 * shareWithin(errors_m, 1, errors_m.size()), harmed,
               ms.empty() ? 0 : quantile(ms, .5));
  }
};

double timeOf(const Localization& fix) {
  double sum = 0;
  for (const auto& [name, ms] : fix.timing_ms)
    sum += name == "posterior" || name == "refine" ? ms : 0;
  return sum;
}

double errorOf(const Localization& fix, const Eigen::Isometry3d& truth) {
  constexpr double kLost_m = 1e9;
  return fix.hypotheses.empty() ? kLost_m
                                : (fix.T_map_sensor.translation() - truth.translation()).norm();
}

/// The stages one by one and together, all from the place that the search finds.
class Stages {
 public:
  Stages(const map::SemanticMap& map, const Arguments& a)
      : search_(map, withStages(a.options, false, false)),
        posterior_(map, withStages(a.options, true, false)),
        refinement_(map, withStages(a.options, false, true)),
        both_(map, withStages(a.options, true, true)) {
    if (a.walks) walks_.emplace(map, walksAlone(a.options));
  }

  void run(const Session& s, const Arguments& a) const {
    Stage walks{"walks", {}, {}, 0}, search{"search", {}, {}, 0};
    std::array<Stage, 3> after{
        {{"+ posterior", {}, {}, 0}, {"+ refinement", {}, {}, 0}, {"both", {}, {}, 0}}};
    const std::array<const Localizer*, 3> localizers{&posterior_, &refinement_, &both_};
    for (const auto& [first, last] : windowsOf(s, a.window_m, a.stride_m)) {
      const Query query =
          makeQuery(s.frames.data() + first, s.frames.data() + last, s.labels, a.options);
      const Eigen::Isometry3d& truth = s.truth[last - 1].T_frame_sensor;
      if (walks_) walks.add(errorOf(walks_->localize(query), truth), 0);
      const Localization found = search_.localize(query);
      const double before_m = errorOf(found, truth);
      if (!(before_m <= kSamePlace_m)) continue;
      search.add(before_m, before_m);
      PoseCheck place;
      place.T_map_query = found.T_map_query;
      for (std::size_t k = 0; k < after.size(); ++k) {
        const Localization fix = localizers[k]->describe(query, place);
        after[k].add(errorOf(fix, truth), before_m);
        after[k].ms.push_back(timeOf(fix));
      }
    }
    fmt::print("{}\n", s.name);
    if (walks_) walks.print();
    search.print();
    for (const Stage& stage : after) stage.print();
    std::fflush(stdout);
  }

 private:
  const Localizer search_, posterior_, refinement_, both_;
  std::optional<Localizer> walks_;
};

}  // namespace

int main(int argc, char** argv) try {
  const Arguments a = parse(argc, argv);
  const auto source = io::openRecording(a.sessions[0]);
  Options parallel = a.options;
  parallel.threads = 0;
  const map::SemanticMap map = buildMap({source.get()}, parallel);
  const Stages stages(map, a);
  fmt::print("map {}, windows of {} m every {} m\n", a.sessions[0], a.window_m, a.stride_m);
  fmt::print("  stage             n | median    p90 | <=.3m <=.5m  <=1m | harmed |  ms\n");
  for (std::size_t i = 1; i < a.sessions.size(); ++i)
    stages.run(loadSession(a.sessions[i], a.options), a);
  return 0;
} catch (const std::exception& e) {
  std::cerr << "error: " << e.what() << "\n";
  return 1;
}
