// SPDX-License-Identifier: BSD-3-Clause
// Other methods on circles cut out of a graph of things, in another graph of the same frame.
//
//   object_baselines_bench CLASSES.yaml MAP.ply QUERY.ply [--methods search,walks,...]
//                          [--radius 200] [--queries 100] [--seed 7]
//
// For each method the share of circles placed within 5 and 20 m, and the median CPU time.
#include <fmt/core.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "base/pose.h"
#include "base/random.h"
#include "baselines/baseline.h"
#include "io/graph_files.h"
#include "search/search.h"
#include "xview/base/error.h"
#include "xview/io/label_files.h"

namespace {

using namespace xview;

class PlaceSearch final : public Baseline {
 public:
  PlaceSearch(const SemanticGraph& map, const LabelSet& labels)
      : field_(search::makeObjectField(map, labels, {})) {}
  std::optional<Eigen::Isometry3d> localize(const SemanticGraph& query) const override {
    const search::SearchResult result =
        search::search(*field_->prepare({nullptr, &query, {}}), {}, {}, 1);
    if (result.places.empty()) return std::nullopt;
    return result.places[0].T_map_query;
  }

 private:
  std::unique_ptr<const search::Field> field_;
};

std::unique_ptr<Baseline> make(const std::string& method, const SemanticGraph& map,
                               const LabelSet& labels) {
  if (method == "search") return std::make_unique<PlaceSearch>(map, labels);
  if (method == "walks") return makeWalks(map, labels);
  if (method == "clique") return makeAllPairsClique(map, labels);
  if (method == "triangles") return makeTriangleHash(map, labels);
  if (method == "fpfh") return makeFpfhPrerejective(map);
  throw UsageError("method " + method + ", must be search, walks, clique, triangles or fpfh");
}

struct Query {
  SemanticGraph graph;  ///< without edges, in a frame of its own
  Eigen::Isometry3d T_map_query;
};

/// What stands around random vertices, moved and turned; circles with few vertices are left out.
std::vector<Query> cutCircles(const SemanticGraph& graph, double radius_m, std::size_t count,
                              std::uint64_t seed) {
  constexpr std::size_t kFewest = 20;
  Random random(seed);
  std::vector<Query> queries;
  for (std::size_t tries = 0; queries.size() < count && tries < 100 * count; ++tries) {
    const auto chosen = random.below(static_cast<std::uint32_t>(graph.size()));
    const Eigen::Vector3d middle = graph.vertices[chosen].position;
    Query query{{}, poseFromYaw(middle, random.uniform(-M_PI, M_PI))};
    for (Vertex v : graph.vertices) {
      if ((v.position - middle).head<2>().norm() > radius_m) continue;
      v.position = query.T_map_query.inverse() * v.position;
      v.instance = 0;
      query.graph.vertices.push_back(v);
    }
    query.graph.setEdges({});
    if (query.graph.size() >= kFewest) queries.push_back(std::move(query));
  }
  return queries;
}

double cpuMilliseconds() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

void ask(const std::string& name, const Baseline& method, const std::vector<Query>& queries) {
  int within5 = 0, within20 = 0;
  std::vector<double> ms;
  for (const Query& q : queries) {
    const double start = cpuMilliseconds();
    const std::optional<Eigen::Isometry3d> T = method.localize(q.graph);
    ms.push_back(cpuMilliseconds() - start);
    if (!T) continue;
    const double error = (T->translation() - q.T_map_query.translation()).head<2>().norm();
    within5 += error <= 5;
    within20 += error <= 20;
  }
  std::sort(ms.begin(), ms.end());
  const double n = static_cast<double>(queries.size()) / 100;
  fmt::print("{:<10} {:>6.1f} {:>6.1f} {:>9.1f}\n", name, within5 / n, within20 / n,
             ms[ms.size() / 2]);
  std::cout.flush();
}

}  // namespace

int main(int argc, char** argv) try {
  std::map<std::string, std::string> flags{{"--methods", "search,walks,clique,triangles,fpfh"},
                                           {"--radius", "200"},
                                           {"--queries", "100"},
                                           {"--seed", "7"}};
  if (argc < 4) throw UsageError("needs CLASSES.yaml MAP.ply QUERY.ply");
  for (int i = 4; i < argc; i += 2) {
    if (flags.count(argv[i]) == 0) throw UsageError(std::string("unknown argument ") + argv[i]);
    if (i + 1 == argc) throw UsageError(std::string(argv[i]) + " needs a value");
    flags[argv[i]] = argv[i + 1];
  }
  const LabelSet labels = io::readLabelSet(argv[1]);
  const SemanticGraph map = io::readGraph(argv[2]).graph;
  const std::vector<Query> queries =
      cutCircles(io::readGraph(argv[3]).graph, std::stod(flags["--radius"]),
                 std::stoul(flags["--queries"]), std::stoull(flags["--seed"]));
  if (queries.empty()) throw Error(argv[3], "no circle has enough vertices");
  fmt::print("{} vertices, {} circles\n{:<10} {:>6} {:>6} {:>9}\n", map.size(), queries.size(),
             "method", "<=5m%", "<=20m%", "ms med");
  std::istringstream methods(flags["--methods"]);
  for (std::string name; std::getline(methods, name, ',');)
    ask(name, *make(name, map, labels), queries);
  return 0;
} catch (const std::exception& e) {
  std::cerr << "object_baselines_bench: " << e.what() << '\n';
  return 1;
}
