// SPDX-License-Identifier: BSD-3-Clause
// Other methods on the queries of place_search_bench.
//
//   object_baselines_bench [--sizes 3,9] [--noise perfect,medium,noisy] [--view rear,aerial]
//                          [--methods search,walks,clique,triangles,fpfh] [--queries 50]
//                          [--length 60] [--seed 7]
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iostream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "baselines/baseline.h"
#include "object_town.h"
#include "session.h"
#include "xview/search/search.h"
#include "xview/types/error.h"

namespace {

using namespace xview;
using namespace xview::bench;

class PlaceSearch final : public Baseline {
 public:
  PlaceSearch(const SemanticGraph& map, const LabelSet& labels)
      : field_(search::makeObjectField(map, labels, {})) {}
  std::optional<Eigen::Isometry3d> localize(const SemanticGraph& query) const override {
    const search::SearchResult result =
        search::search(*field_->prepare({nullptr, &query, {}, {}}), {}, {}, 1);
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

TownNoise noiseNamed(const std::string& name) {
  if (name == "perfect") return TownNoise::perfect();
  if (name == "medium") return TownNoise::medium();
  if (name == "noisy") return TownNoise::noisy();
  throw UsageError("noise " + name + ", must be perfect, medium or noisy");
}

struct Row {
  int asked = 0, within5 = 0, within20 = 0;
  std::vector<double> ms;
};

Row ask(const Baseline& method, const std::vector<TownQuery>& queries) {
  Row row;
  for (const TownQuery& q : queries) {
    const double start = cpuMilliseconds();
    const std::optional<Eigen::Isometry3d> T = method.localize(q.graph);
    row.ms.push_back(cpuMilliseconds() - start);
    ++row.asked;
    if (!T) continue;
    const double error = (*T * q.last_in_query - q.last_in_map).head<2>().norm();
    row.within5 += error <= 5;
    row.within20 += error <= 20;
  }
  std::sort(row.ms.begin(), row.ms.end());
  return row;
}

void compare(std::map<std::string, std::string>& a, int size, const std::string& noise_name) {
  const std::uint64_t seed = std::stoull(a["--seed"]);
  const TownNoise noise = noiseNamed(noise_name);
  const ObjectTown town(size, seed);
  const SemanticGraph map = mapObjectTown(town, noise, {}, 1);
  const LabelSet labels = objectTownLabels();
  for (const std::string& view : words(a["--view"])) {
    std::vector<TownQuery> queries;
    for (int i = 0; i < std::stoi(a["--queries"]); ++i) {
      queries.push_back(
          queryObjectTown(town, noise, {}, view == "aerial" ? TownView::aerial : TownView::rear,
                          std::stod(a["--length"]), seed * 100000 + static_cast<std::uint64_t>(i)));
    }
    for (const std::string& name : words(a["--methods"])) {
      const Row row = ask(*make(name, map, labels), queries);
      const double n = std::max(1, row.asked);
      fmt::print("{:>8} {:<8} {:<7} {:<10} {:>6.1f} {:>6.1f} {:>9.1f}\n", map.size(), noise_name,
                 view, name, 100 * row.within5 / n, 100 * row.within20 / n,
                 row.ms.empty() ? 0.0 : row.ms[row.ms.size() / 2]);
      std::cout.flush();
    }
  }
}

}  // namespace

int main(int argc, char** argv) try {
  std::map<std::string, std::string> a{{"--sizes", "3,9"},
                                       {"--noise", "perfect,medium,noisy"},
                                       {"--view", "rear,aerial"},
                                       {"--methods", "search,walks,clique,triangles,fpfh"},
                                       {"--queries", "50"},
                                       {"--length", "60"},
                                       {"--seed", "7"}};
  for (int i = 1; i < argc; i += 2) {
    if (a.count(argv[i]) == 0) throw UsageError(std::string("unknown argument ") + argv[i]);
    if (i + 1 == argc) throw UsageError(std::string(argv[i]) + " needs a value");
    a[argv[i]] = argv[i + 1];
  }
  fmt::print("{:>8} {:<8} {:<7} {:<10} {:>6} {:>6} {:>9}\n", "map", "noise", "view", "method",
             "<=5m%", "<=20m%", "ms med");
  for (const std::string& size : words(a["--sizes"])) {
    for (const std::string& noise : words(a["--noise"])) compare(a, std::stoi(size), noise);
  }
  return 0;
} catch (const std::exception& e) {
  std::cerr << "object_baselines_bench: " << e.what() << '\n';
  return 1;
}
