// SPDX-License-Identifier: BSD-3-Clause
// Place search in bare object graphs: success, precision and recall of the verdict, time and
// memory.
//
//   place_search_bench [--sizes 4,12,38,119] [--noise perfect,medium,noisy] [--view rear,aerial]
//   [--length 60]
//                      [--queries 100] [--negatives 50] [--towns 1] [--seed 7] [--surface 3]
//                      [--threads 1] [--csv FILE] [--KEY VALUE]...
//   place_search_bench --map NEW.ply --query OLD.ply [--classes classes.yaml] [--radius 200]
//   [--queries 200] [--KEY VALUE]...
//
// The first form builds seeded towns of 3, 9, 28, 88 ... streets per side (10^3, 10^4, 10^5, 10^6
// vertices) and asks for the poses of drives through them, and through a town of another seed,
// which must be refused. Queries are spread over --towns towns of seeds one apart: a small town
// has but one style of street. The second takes random circles out of one graph and looks for them
// in another one of the same frame. Options of the search and of the verdict are --KEY VALUE.
#include <fmt/core.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iostream>
#include <map>
#include <sstream>
#include <string>
#include <type_traits>
#include <vector>

#include "../src/pipeline/object_evidence.h"
#include "object_town.h"
#include "session.h"
#include "xview/eval/evaluation.h"
#include "xview/io/graph_files.h"
#include "xview/io/label_files.h"
#include "xview/search/search.h"
#include "xview/types/error.h"
#include "xview/types/pose.h"
#include "xview/types/random.h"
#include "xview/verify/object_verdict.h"

namespace {

using namespace xview;
using namespace xview::bench;

constexpr double kPi = 3.14159265358979323846;
constexpr double kSuccess_m = 5;

struct Arguments {
  std::vector<std::string> sizes{"3", "9", "28"}, noises{"perfect", "medium", "noisy"},
      views{"rear", "aerial"};
  double length_m = 60, radius_m = 200, surface_m = 3;
  int queries = 100, negatives = 50, towns = 1, threads = 1;
  std::uint64_t seed = 7;
  std::string csv, map, query, classes;
  search::SearchOptions search;  // with the 5 hypotheses that the localizer reports
  ObjectVerdictOptions verdict;
};

/// Sets the numeric option of a given name.
struct Setter {
  std::string name, value;
  bool* done;
  template <class Number, class... Rest>
  void operator()(const char* field, Number& number, Rest&&...) const {
    if (name != field) return;
    if constexpr (std::is_arithmetic_v<Number>) {
      number = static_cast<Number>(std::stod(value));
      *done = true;
    }
  }
};

Arguments parse(int argc, char** argv) {
  Arguments a;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string key = argv[i], value = argv[i + 1];
    if (key == "--sizes")
      a.sizes = words(value);
    else if (key == "--noise")
      a.noises = words(value);
    else if (key == "--view")
      a.views = words(value);
    else if (key == "--length")
      a.length_m = std::stod(value);
    else if (key == "--surface")
      a.surface_m = std::stod(value);
    else if (key == "--radius")
      a.radius_m = std::stod(value);
    else if (key == "--queries")
      a.queries = std::stoi(value);
    else if (key == "--negatives")
      a.negatives = std::stoi(value);
    else if (key == "--towns")
      a.towns = std::max(1, std::stoi(value));
    else if (key == "--threads")
      a.threads = std::stoi(value);
    else if (key == "--seed")
      a.seed = std::stoull(value);
    else if (key == "--csv")
      a.csv = value;
    else if (key == "--map")
      a.map = value;
    else if (key == "--query")
      a.query = value;
    else if (key == "--classes")
      a.classes = value;
    else {
      bool done = false;
      const Setter set{key.substr(std::min<std::size_t>(2, key.size())), value, &done};
      visit(a.search, set);
      visit(a.verdict, set);
      if (!done) throw UsageError("unknown argument " + key);
    }
  }
  if (argc % 2 == 0) throw UsageError(std::string(argv[argc - 1]) + " needs a value");
  return a;
}

double peakMegabytes() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

/// One query and its answer. Queries from elsewhere have no error.
struct Trial {
  bool is_negative = false;
  double error_m = INFINITY;
  ObjectEvidence evidence;
  bool accepted = false;
  double ms = 0;
  bool isRight() const { return error_m <= kSuccess_m; }
  double confidence = 0;
};

Trial run(const search::Field& field, const SemanticGraph& graph, const Eigen::Vector3d& focus,
          const Eigen::Vector3d* truth, const Arguments& a) {
  const double start = cpuMilliseconds();
  const search::SearchResult result =
      search::search(*field.prepare({nullptr, &graph, {}, focus}), {}, a.search, a.threads);
  Trial trial;
  trial.ms = cpuMilliseconds() - start;
  trial.is_negative = truth == nullptr;
  trial.evidence = evidenceOf(result);
  if (result.places.empty()) return trial;
  if (truth) trial.error_m = (result.places[0].T_map_query * focus - *truth).norm();
  const Verdict verdict = judge(trial.evidence, a.verdict);
  trial.accepted = verdict.status == Status::accepted;
  trial.confidence = verdict.confidence;
  return trial;
}

/// Largest share of the answerable queries that a threshold on the confidence accepts with 99 %
/// precision.
double recallAt99(const std::vector<Trial>& trials) {
  std::vector<Detection> detections;
  std::size_t answerable = 0;
  for (const Trial& t : trials) {
    detections.push_back({t.confidence, t.isRight()});
    answerable += !t.is_negative;
  }
  double best = 0;
  for (const PrecisionRecall& p : precisionRecallCurve(detections, answerable)) {
    if (p.precision >= 0.99) best = std::max(best, p.recall);
  }
  return best;
}

void printHeader() {
  fmt::print(
      "{:<26} {:>8} {:>5} | {:>6} {:>6} {:>6} | {:>6} | {:>6} {:>6} {:>9} | {:>7} {:>7} | {:>6} "
      "{:>6}\n",
      "setting", "map", "query", "<=5m%", "<=1m%", "med m", "R@99P%", "acc.%", "prec.%",
      "false acc", "ms med", "ms p95", "idx MB", "RSS MB");
}

/// Size and memory of the indices that were searched.
struct MapSize {
  double vertices = 0, bytes = 0;
};

void printRow(const std::string& name, const MapSize& map, const std::vector<Trial>& trials) {
  std::vector<double> errors, times, sizes;
  int answerable = 0, within5 = 0, within1 = 0, accepted = 0, accepted_right = 0, false_accepts = 0;
  for (const Trial& t : trials) {
    times.push_back(t.ms);
    accepted += t.accepted;
    accepted_right += t.accepted && t.isRight();
    false_accepts += t.accepted && t.is_negative;
    if (t.is_negative) continue;
    ++answerable;
    sizes.push_back(t.evidence.vertices);
    within5 += t.isRight();
    within1 += t.error_m <= 1;
    if (t.isRight()) errors.push_back(t.error_m);
  }
  const double n = std::max(1, answerable);
  fmt::print(
      "{:<26} {:>8.0f} {:>5.0f} | {:>6.1f} {:>6.1f} {:>6.2f} | {:>6.1f} | {:>6.1f} {:>6.1f} {:>9} "
      "| "
      "{:>7.1f} {:>7.1f} | {:>6.1f} {:>6.0f}\n",
      name, map.vertices, quantile(sizes, 0.5), 100 * within5 / n, 100 * within1 / n,
      quantile(errors, 0.5), 100 * recallAt99(trials), 100 * accepted_right / n,
      accepted > 0 ? 100.0 * accepted_right / accepted : 100.0, false_accepts, quantile(times, 0.5),
      quantile(times, 0.95), map.bytes / 1e6, peakMegabytes());
  std::cout.flush();
}

void writeCsv(const std::string& path, const std::string& name, const std::vector<Trial>& trials) {
  if (path.empty()) return;
  std::ofstream file(path, std::ios::app);
  for (const Trial& t : trials) {
    const ObjectEvidence& e = t.evidence;
    file << fmt::format("{},{},{:.2f},{:.2f},{:.2f},{:.2f},{:.3f},{},{:.2f},{:.2f},{},{:.4f},{}\n",
                        name, t.is_negative ? 1 : 0, std::min(t.error_m, 1e6), e.score, e.runner_up,
                        e.expected, e.known_share, e.vertices, e.typical_wrong, e.wrong_deviation,
                        e.wrong_places, t.confidence, t.accepted ? 1 : 0);
  }
}

TownNoise noiseNamed(const std::string& name) {
  if (name == "perfect") return TownNoise::perfect();
  if (name == "medium") return TownNoise::medium();
  if (name == "noisy") return TownNoise::noisy();
  throw UsageError("noise " + name + ", must be perfect, medium or noisy");
}

TownView viewNamed(const std::string& name) {
  if (name == "rear") return TownView::rear;
  if (name == "aerial") return TownView::aerial;
  if (name == "forward") return TownView::forward;
  throw UsageError("view " + name + ", must be rear, aerial or forward");
}

/// The k-th part of n things shared out among a.towns towns.
int shareOf(int n, int k, const Arguments& a) { return n * (k + 1) / a.towns - n * k / a.towns; }

/// Queries in the k-th town and from another one of its kind.
void askInTown(const Arguments& a, int size, const TownNoise& noise, int k, MapSize& map,
               std::vector<std::vector<Trial>>& trials_of_view) {
  const TownSampling sampling{a.surface_m, 2};
  const std::uint64_t seed = a.seed + static_cast<std::uint64_t>(k);
  const ObjectTown town(size, seed), elsewhere(std::clamp(size, 6, 30), seed + 1000);
  const auto field = search::makeObjectField(mapObjectTown(town, noise, sampling, 1),
                                             objectTownLabels(), a.search);
  map.vertices += static_cast<double>(field->size()) / a.towns;
  map.bytes += static_cast<double>(field->bytes()) / a.towns;
  const int queries = shareOf(a.queries, k, a), negatives = shareOf(a.negatives, k, a);
  for (std::size_t v = 0; v < a.views.size(); ++v) {
    for (int i = 0; i < queries + negatives; ++i) {
      const bool is_negative = i >= queries;
      const TownQuery q =
          queryObjectTown(is_negative ? elsewhere : town, noise, sampling, viewNamed(a.views[v]),
                          a.length_m, seed * 100000 + static_cast<std::uint64_t>(i));
      trials_of_view[v].push_back(
          run(*field, q.graph, q.last_in_query, is_negative ? nullptr : &q.last_in_map, a));
    }
  }
}

void benchTowns(const Arguments& a, int size, const std::string& noise) {
  MapSize map;
  std::vector<std::vector<Trial>> trials_of_view(a.views.size());
  for (int k = 0; k < a.towns; ++k) askInTown(a, size, noiseNamed(noise), k, map, trials_of_view);
  for (std::size_t v = 0; v < a.views.size(); ++v) {
    const std::string name = fmt::format("{} {} {} {:.0f} m", size, noise, a.views[v], a.length_m);
    printRow(name, map, trials_of_view[v]);
    writeCsv(a.csv, name, trials_of_view[v]);
  }
}

LabelSet labelsOf(const Arguments& a, const SemanticGraph& graph) {
  if (!a.classes.empty()) return io::readLabelSet(a.classes);
  std::vector<std::uint32_t> ids;
  for (const Vertex& v : graph.vertices) ids.push_back(v.label);
  return genericLabelSet(ids);
}

/// A circle out of a graph, in a frame of its own.
SemanticGraph cutCircle(const SemanticGraph& graph, const Eigen::Vector2d& centre, double radius,
                        const Eigen::Isometry3d& T_map_query) {
  SemanticGraph cut;
  for (const Vertex& v : graph.vertices) {
    if ((v.position.head<2>() - centre).norm() > radius) continue;
    cut.vertices.push_back(v);
    cut.vertices.back().position = T_map_query.inverse() * v.position;
  }
  cut.neighbours.resize(cut.size());
  return cut;
}

void benchCircles(const Arguments& a) {
  constexpr std::size_t kFewest = 15;  // vertices of a query
  const SemanticGraph map = io::readGraph(a.map).graph, source = io::readGraph(a.query).graph;
  const auto field = search::makeObjectField(map, labelsOf(a, map), a.search);
  Random random(a.seed);
  std::vector<Trial> trials;
  for (int attempt = 0; attempt < 100 * a.queries && static_cast<int>(trials.size()) < a.queries;
       ++attempt) {
    const Eigen::Vector3d near =
        source.vertices.at(random.below(static_cast<std::uint32_t>(source.size()))).position;
    const Eigen::Vector3d centre =
        near + 0.5 * a.radius_m * Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), 0);
    const Eigen::Isometry3d T_map_query = poseFromYaw(
        centre + Eigen::Vector3d(random.uniform(-100, 100), random.uniform(-100, 100), 0),
        random.uniform(-kPi, kPi));
    const SemanticGraph query = cutCircle(source, centre.head<2>(), a.radius_m, T_map_query);
    if (query.size() < kFewest) continue;
    trials.push_back(run(*field, query, T_map_query.inverse() * centre, &centre, a));
  }
  const MapSize size{static_cast<double>(field->size()), static_cast<double>(field->bytes())};
  printRow(fmt::format("circles of {:.0f} m", a.radius_m), size, trials);
  writeCsv(a.csv, a.query, trials);
}

}  // namespace

int main(int argc, char** argv) try {
  const Arguments a = parse(argc, argv);
  printHeader();
  if (!a.map.empty()) {
    benchCircles(a);
    return 0;
  }
  for (const std::string& size : a.sizes) {
    for (const std::string& noise : a.noises) benchTowns(a, std::stoi(size), noise);
  }
  return 0;
} catch (const std::exception& e) {
  std::cerr << "place_search_bench: " << e.what() << '\n';
  return 1;
}
