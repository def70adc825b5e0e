// SPDX-License-Identifier: BSD-3-Clause
#include "xview/localizer.h"

#include <fmt/core.h>

#include <optional>

#include "pipeline/explain.h"
#include "pipeline/object_path.h"
#include "pipeline/place_path.h"
#include "pipeline/pose_prior.h"
#include "pipeline/pose_refinement.h"
#include "pipeline/upright_frame.h"
#include "pipeline/walk_path.h"
#include "pipeline/walk_proposer.h"
#include "xview/types/error.h"
#include "xview/types/stopwatch.h"

namespace xview {
namespace {

std::vector<Eigen::Vector3d> trajectoryOf(const SemanticMap& map) {
  std::vector<Eigen::Vector3d> path;
  for (const Keyframe& k : map.keyframes) path.push_back(k.T_map_sensor.translation());
  return path;
}

void requireKnownLabels(const LabelSet& map, const LabelSet& query) {
  for (const auto& [id, info] : query.classes()) {
    const ClassInfo* known = map.find(id);
    if (known && known->name != info.name) {
      throw Error("label set '" + query.name() + "'", fmt::format("class {} is '{}' here but '{}' in the map (label set '{}')", id, info.name,
                                                                  known->name, map.name()));
    }
  }
}

std::unique_ptr<const PlanPlaces> planPlaces(const SemanticMap& map, const Options& options) {
  if (options.method == "walks" || map.plan.known.empty()) return nullptr;
  const std::string& file = options.places.likelihoods;
  return std::make_unique<PlanPlaces>(map.plan, trajectoryOf(map), file.empty() ? defaultLikelihoods() : readLikelihoods(file), options.places,
                                      options.threads);
}

}  // namespace

/// What is made once per map, and the paths that a query may take through it.
struct Localizer::Index {
  Index(const SemanticMap& semantic_map, const Options& all_options)
      : turned(uprightMap(semantic_map)), map(turned ? *turned : semantic_map), options(all_options), prior(parsePrior(options.prior)),
        walks(map.graph, map.labels, options), places(planPlaces(map, options)), walk_path(map, walks, prior, options),
        object_path(map, prior, options), refinement(map, places.get(), options) {
    if (places) place_path.emplace(*places, walks, prior, options);
  }

  /// Query and map gravity-aligned.
  Localization localize(const Query& query) const {
    Localization answer;
    const PlanQuery plan_query = places ? makePlanQuery(query.plan) : PlanQuery();
    if (options.method == "walks") walk_path.localize(query, answer);
    else if (place_path && !query.plan.known.empty()) place_path->localize(query, plan_query, answer);
    else object_path.localize(query, answer);
    if (!answer.hypotheses.empty()) refinement.refine(query, plan_query, answer);
    return answer;
  }

  const std::optional<SemanticMap> turned;
  const SemanticMap& map;  ///< gravity-aligned: the caller's, or `turned`
  const Options options;
  const PlacePrior prior;
  const WalkProposer walks;
  const std::unique_ptr<const PlanPlaces> places;
  const WalkPath walk_path;
  const ObjectPath object_path;
  const PoseRefinement refinement;
  std::optional<PlacePath> place_path;
};

Localizer::Localizer(const SemanticMap& map, const Options& options) : index_(std::make_unique<Index>(map, options)) {}
Localizer::~Localizer() = default;

Localization Localizer::localize(const Query& query) const {
  Stopwatch watch;
  requireKnownLabels(index_->map.labels, query.labels);
  Localization answer = index_->localize(isTurned(query.plan.upright) ? uprightQuery(query) : query);
  leaveUprightFrames(index_->map.plan.upright, query, answer);
  double total = watch.lap_ms();
  for (const auto& [stage, ms] : query.timing_ms) total += ms;
  answer.timing_ms.insert(answer.timing_ms.begin(), query.timing_ms.begin(), query.timing_ms.end());
  answer.timing_ms.emplace_back("total", total);
  return answer;
}

Explanation Localizer::explain(const Query& query, const Localization& answer) const {
  Explanation explanation;
  if (answer.hypotheses.empty()) return explanation;
  const SemanticMap& map = index_->map;
  const Query upright = uprightQuery(query);
  const Eigen::Isometry3d T = map.plan.upright * answer.T_map_query * query.plan.upright.conjugate();
  if (index_->places && !query.plan.known.empty()) {
    explainSamples(*index_->places, map.plan, upright, makePlanQuery(query.plan), T, explanation);
  }
  explainVertices(map, upright, answer.kept, T, explanation);
  turn(map.plan.upright.conjugate(), explanation);
  return explanation;
}

}  // namespace xview
