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
        walks(map.graph, map.labels, options), places(planPlaces(map, options)), walk_path(map, walks, options),
        object_path(map, options), refinement(map, places.get(), options) {
    if (places) place_path.emplace(*places, walks, options);
  }

  Localization answerTo(const Query& query, const ExpectedPose* expected) const;

  bool takesPlacePath(const Query& query) const { return place_path && !query.plan.known.empty(); }
  PlanQuery planQuery(const Query& query) const {
    if (!places) return {};
    std::vector<Eigen::Vector2d> way;
    for (const Eigen::Isometry3d& T : query.poses) way.emplace_back(T.translation().head<2>());
    return makePlanQuery(query.plan, way);
  }

  /// Query and map gravity-aligned, as in all of these.
  Localization localize(const Query& query, const Priors& priors) const {
    Localization answer;
    const PlanQuery plan_query = planQuery(query);
    if (options.method == "walks") walk_path.localize(query, priors, answer);
    else if (takesPlacePath(query)) place_path->localize(query, plan_query, priors, answer);
    else object_path.localize(query, priors, answer);
    if (!answer.hypotheses.empty()) refinement.refine(query, plan_query, answer);
    refuseOutside(priors, query, answer);
    return answer;
  }

  std::vector<PoseCheck> check(const Query& query, const std::vector<Eigen::Isometry3d>& T_map_query, double reach_m) const {
    if (options.method == "walks") throw UsageError("method = walks cannot say what speaks for a given pose");
    const PlanQuery plan_query = planQuery(query);
    std::vector<PoseCheck> checked;
    for (const Eigen::Isometry3d& T : T_map_query) {
      checked.push_back(takesPlacePath(query) ? place_path->check(query, plan_query, T, reach_m) : object_path.check(query, T, reach_m));
    }
    return checked;
  }

  Localization describe(const Query& query, const PoseCheck& place) const {
    Localization answer;
    const PlanQuery plan_query = planQuery(query);
    answer.hypotheses.push_back({place.T_map_query, place.evidence.score, 0, Proposer::search});
    if (takesPlacePath(query)) place_path->findPairs(query, plan_query, answer);
    refinement.refine(query, plan_query, answer);
    return answer;
  }

  Eigen::Isometry3d toUpright(const Query& query, const Eigen::Isometry3d& T_map_query) const {
    return map.plan.upright * T_map_query * query.plan.upright.conjugate();
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

Localization Localizer::localize(const Query& query) const { return index_->answerTo(query, nullptr); }

Localization Localizer::localize(const Query& query, const ExpectedPose& expected) const { return index_->answerTo(query, &expected); }

/// In the frames of the caller, with all times.
Localization Localizer::Index::answerTo(const Query& query, const ExpectedPose* expected) const {
  Stopwatch watch;
  requireKnownLabels(map.labels, query.labels);
  const UprightQuery upright(query);
  Priors priors{prior};
  if (expected) priors.push_back(priorAround({toUpright(query, expected->T_map_query), expected->radius_m, expected->yaw_rad}, upright.query));
  Localization answer = localize(upright.query, priors);
  // A pose that is expected comes from a fix; one that a user believes in is to be doubted.
  if (!expected && (prior.near || prior.heading) && answer.accepted() && takesPlacePath(query)) {
    place_path->refuteFromOutside(upright.query, planQuery(upright.query), priors, answer);
  }
  leaveUprightFrames(map.plan.upright, query, answer);
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
  const UprightQuery upright(query);
  const Eigen::Isometry3d T = index_->toUpright(query, answer.T_map_query);
  if (index_->takesPlacePath(query)) {
    explainSamples(*index_->places, map.plan, upright.query, index_->planQuery(query), T, explanation);
  }
  explainVertices(map, upright.query, answer.kept, T, explanation);
  turn(map.plan.upright.conjugate(), explanation);
  return explanation;
}

std::vector<PoseCheck> Localizer::check(const Query& query, const std::vector<Eigen::Isometry3d>& T_map_query, double reach_m) const {
  std::vector<Eigen::Isometry3d> upright;
  for (const Eigen::Isometry3d& T : T_map_query) upright.push_back(index_->toUpright(query, T));
  std::vector<PoseCheck> places = index_->check(UprightQuery(query).query, upright, reach_m);
  for (PoseCheck& p : places) p.T_map_query = index_->map.plan.upright.conjugate() * p.T_map_query * query.plan.upright;
  return places;
}

Localization Localizer::describe(const Query& query, const PoseCheck& place) const {
  PoseCheck upright = place;
  upright.T_map_query = index_->toUpright(query, place.T_map_query);
  Localization answer = index_->describe(UprightQuery(query).query, upright);
  leaveUprightFrames(index_->map.plan.upright, query, answer);
  return answer;
}

}  // namespace xview
