// SPDX-License-Identifier: BSD-3-Clause
#include "baselines/baseline.h"
#include "xview/localizer.h"

namespace xview {
namespace {

map::SemanticMap mapOf(const SemanticGraph& graph, const LabelSet& labels) {
  map::SemanticMap map;
  map.graph = graph;
  map.labels = labels;
  return map;
}

Options walkOptions() {
  Options options;
  options.method = "walks";
  options.threads = 1;
  options.consensus.iterations = 100000;
  return options;
}

class Walks final : public Baseline {
 public:
  Walks(const SemanticGraph& graph, const LabelSet& labels)
      : options_(walkOptions()), localizer_(mapOf(graph, labels), options_) {}

  std::optional<Eigen::Isometry3d> localize(const SemanticGraph& query) const override {
    const Localization answer =
        localizer_.localize(makeQuery(query, localizer_.labels(), options_));
    if (answer.hypotheses.empty()) return std::nullopt;
    return answer.T_map_query;
  }

 private:
  Options options_;
  Localizer localizer_;
};

}  // namespace

std::unique_ptr<Baseline> makeWalks(const SemanticGraph& map, const LabelSet& labels) {
  return std::make_unique<Walks>(map, labels);
}

}  // namespace xview
