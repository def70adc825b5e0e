// SPDX-License-Identifier: BSD-3-Clause
#include "xview/localizer.h"

#include <fmt/core.h>

#include <cmath>
#include <optional>

#include "pipeline/explain.h"
#include "pipeline/free_path.h"
#include "pipeline/gravity.h"
#include "pipeline/level_on_map.h"
#include "pipeline/object_path.h"
#include "pipeline/place_path.h"
#include "pipeline/planar_pose.h"
#include "pipeline/pose_prior.h"
#include "pipeline/pose_refinement.h"
#include "pipeline/scale_search.h"
#include "pipeline/upright_frame.h"
#include "pipeline/view_point.h"
#include "pipeline/walk_path.h"
#include "pipeline/walk_proposer.h"
#include "xview/types/error.h"
#include "xview/types/prior_text.h"
#include "xview/types/stopwatch.h"

namespace xview {
namespace {

constexpr double kFreeSigma_rad = 0.3;  ///< up by nothing but the pose that was found

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

void sayLevelled(const LevelledQuery& level, Localization& answer) {
  constexpr double kDegrees = 180 / M_PI;
  if (answer.gravity == GravityUse::aligned) answer.gravity = GravityUse::levelled;
  answer.gravity_reason = fmt::format("; turned by {:.1f} +- {:.1f} deg onto the ground of the map", Eigen::AngleAxisd(level.turn).angle() * kDegrees,
                                      level.up_sigma_rad * kDegrees);
}

/// What was assumed about up, for people; before what the place that was found says about it.
void sayGravity(const Gravity& map, const Query& query, Localization& answer) {
  const bool turned = map.turned() || query.gravity.turned();
  if (answer.gravity == GravityUse::aligned && turned) answer.gravity = GravityUse::levelled;
  answer.gravity_reason = "query: " + query.gravity.reason + "; map: " + map.reason + answer.gravity_reason;
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
  struct Prepared;
  Index(const SemanticMap& semantic_map, const Options& all_options)
      : gravity(gravityOf(semantic_map, all_options.gravity)), turned(uprightMap(semantic_map, gravity.upright)), map(turned ? *turned : semantic_map), options(all_options), prior(parsePrior(options.prior)),
        scales(parseScale("scale", options.scale)),
        walks(map.graph, map.labels, options), places(planPlaces(map, options)), walk_path(map, walks, options),
        object_path(map, options), free_path(walks, object_path, options), refinement(map, places.get(), options) {
    if (places) place_path.emplace(*places, walks, options);
  }

  Localization answerFromViewPoint(const Query& query, const ExpectedPose* expected) const;
  Localization answerTo(const Query& query, const ExpectedPose* expected, double rival_score) const;
  Localization answerInScale(const Query& query, const ExpectedPose* expected) const;
  PoseCheck bestPlace(const Query& query, const ExpectedPose* expected) const;
  std::vector<PoseCheck> checkAsGiven(const Query& query, const std::vector<Eigen::Isometry3d>& T_map_query, double reach_m) const;

  bool takesPlacePath(const Query& query) const { return place_path && !query.plan.known.empty(); }
  PlanQuery planQuery(const Query& query) const {
    if (!places) return {};
    std::vector<Eigen::Vector2d> way;
    for (const Eigen::Isometry3d& T : query.poses) way.emplace_back(T.translation().head<2>());
    return makePlanQuery(query.plan, way);
  }
  bool upIsKnown(const Query& query) const { return gravity.known && query.gravity.known; }
  double upSigma(const Query& query) const { return std::hypot(gravity.sigma_rad, query.gravity.sigma_rad); }

  /// Query and map gravity-aligned, as in all of these. Returns the rotation that the place turns the query upright with.
  Eigen::Quaterniond localize(const Query& query, const Priors& priors, double rival_score, Localization& answer) const {
    const PlanQuery plan_query = planQuery(query);
    if (options.method == "walks") walk_path.localize(query, priors, answer);
    else if (takesPlacePath(query)) place_path->localize(query, plan_query, priors, rival_score, answer);
    else object_path.localize(query, priors, rival_score, answer);
    return finish(query, plan_query, priors, answer);
  }

  Eigen::Quaterniond finish(const Query& query, const PlanQuery& plan_query, const Priors& priors, Localization& answer) const {
    const Eigen::Quaterniond turn = refine(query, plan_query, answer);
    refuseOutside(priors, UprightQuery(query, turn).query, answer);
    return turn;
  }

  /// Levels the query on the ground of the map, if that is needed, and refines its pose.
  Eigen::Quaterniond refine(const Query& query, const PlanQuery& plan_query, Localization& answer) const {
    if (answer.hypotheses.empty()) return Eigen::Quaterniond::Identity();
    const auto level = levelled(query, plan_query, answer.hypotheses[0].T_map_query);
    if (!level) {
      refinement.refine(query, plan_query, upSigma(query), answer);
      return Eigen::Quaterniond::Identity();
    }
    for (Hypothesis& h : answer.hypotheses) h.T_map_query = h.T_map_query * level->turn.conjugate();
    answer.hypotheses[0].T_map_query = level->T_map_query;
    sayLevelled(*level, answer);
    refinement.refine(level->query, level->plan, level->up_sigma_rad, answer);
    return level->turn;
  }

  std::optional<LevelledQuery> levelled(const Query& query, const PlanQuery& plan_query, const Eigen::Isometry3d& T_map_query) const {
    if (options.gravity == "aligned" || plan_query.empty()) return std::nullopt;
    return levelOnMap(*places, query, plan_query, T_map_query, upSigma(query), options);
  }

  /// The map gravity-aligned, the query as it is. Returns the rotation that the pose turns the query upright with.
  Eigen::Quaterniond localizeFreely(const Query& query, const Priors& priors, Localization& answer) const {
    answer.gravity = GravityUse::free;
    const Eigen::Quaterniond upright = free_path.localize(query, priors, answer);
    Query levelled = uprightQuery(query, upright);
    levelled.gravity.sigma_rad = kFreeSigma_rad;
    return finish(levelled, {}, priors, answer) * upright;
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

  /// Returns the same as localize().
  Eigen::Quaterniond describe(const Query& query, const PoseCheck& place, Localization& answer) const {
    const PlanQuery plan_query = planQuery(query);
    answer.hypotheses.push_back({place.T_map_query, place.evidence.score, 0, Proposer::search});
    if (takesPlacePath(query)) place_path->findPairs(query, plan_query, answer);
    return refine(query, plan_query, answer);
  }

  /// Turns the query upright; a pose of it says how, if nothing else does.
  Eigen::Quaterniond uprightOf(const Query& query, const Eigen::Isometry3d& T_map_query) const {
    if (upIsKnown(query)) return query.gravity.upright;
    return uprightBy(T_map_query.linear().transpose() * (gravity.upright.conjugate() * Eigen::Vector3d::UnitZ()));
  }
  Eigen::Isometry3d toUpright(const Query& query, const Eigen::Isometry3d& T_map_query) const {
    return gravity.upright * T_map_query * uprightOf(query, T_map_query).conjugate();
  }

  const Gravity gravity;  ///< of the caller's map
  const std::optional<SemanticMap> turned;
  const SemanticMap& map;  ///< gravity-aligned: the caller's, or `turned`
  const Options options;
  const PlacePrior prior;
  const std::optional<ScaleRange> scales;
  const WalkProposer walks;
  const std::unique_ptr<const PlanPlaces> places;
  const WalkPath walk_path;
  const ObjectPath object_path;
  const FreePath free_path;
  const PoseRefinement refinement;
  std::optional<PlacePath> place_path;
};

Localizer::Localizer(const SemanticMap& map, const Options& options) : index_(std::make_unique<Index>(map, options)) {}
Localizer::~Localizer() = default;

Localization Localizer::localize(const Query& query) const { return index_->answerFromViewPoint(query, nullptr); }

Localization Localizer::localize(const Query& query, const ExpectedPose& expected) const { return index_->answerFromViewPoint(query, &expected); }

Localization Localizer::Index::answerFromViewPoint(const Query& query, const ExpectedPose* expected) const {
  const std::optional<Query> centred = query.cloud.empty() ? std::nullopt : seenFromItsCentre(query);
  if (!centred) return answerInScale(query, expected);
  Localization answer = answerInScale(*centred, expected);
  const Eigen::Vector3d centre = answer.T_map_sensor.translation();
  Eigen::Isometry3d pose = query.poses.back();
  pose.translation() *= answer.scale;
  answer.T_map_sensor = answer.T_map_query * pose;
  answer.covariance = movedCovariance(answer.covariance, centre, answer.T_map_sensor.translation());
  return answer;
}

/// A query upright, and what is known about its pose.
struct Localizer::Index::Prepared {
  Prepared(const Index& index, const Query& given, const ExpectedPose* expected)
      : R_upright(expected ? index.uprightOf(given, expected->T_map_query) : given.gravity.upright), upright(given, R_upright),
        priors{index.prior} {
    if (!expected) return;
    const Eigen::Isometry3d T = index.gravity.upright * expected->T_map_query * R_upright.conjugate();
    priors.push_back(priorAround({T, expected->radius_m, expected->yaw_rad}, upright.query));
  }
  const Query& query() const { return upright.query; }

  Eigen::Quaterniond R_upright;
  UprightQuery upright;
  Priors priors;
};

/// In the frames of the caller, with all times.
Localization Localizer::Index::answerTo(const Query& query, const ExpectedPose* expected, double rival_score) const {
  Stopwatch watch;
  Localization answer;
  Prepared prepared(*this, query, expected);
  const Eigen::Quaterniond turn = upIsKnown(query) ? localize(prepared.query(), prepared.priors, rival_score, answer)
                                                   : localizeFreely(prepared.query(), prepared.priors, answer);
  // A pose that is expected comes from a fix; one that a user believes in is to be doubted.
  if (!expected && (prior.near || prior.heading) && answer.accepted() && takesPlacePath(query)) {
    place_path->refuteFromOutside(prepared.query(), planQuery(prepared.query()), prepared.priors, answer);
  }
  leaveUprightFrames(gravity.upright, turn * prepared.R_upright, query, answer);
  sayGravity(gravity, query, answer);
  double total = watch.lap_ms();
  for (const auto& [stage, ms] : query.timing_ms) total += ms;
  answer.timing_ms.insert(answer.timing_ms.begin(), query.timing_ms.begin(), query.timing_ms.end());
  answer.timing_ms.emplace_back("total", total);
  return answer;
}

/// In the frames of the caller.
std::vector<PoseCheck> Localizer::Index::checkAsGiven(const Query& query, const std::vector<Eigen::Isometry3d>& T_map_query, double reach_m) const {
  const Eigen::Quaterniond R_frame_map = gravity.upright.conjugate();
  if (!upIsKnown(query)) {  // each pose has an up of its own
    std::vector<PoseCheck> checked;
    for (const Eigen::Isometry3d& T : T_map_query) {
      const Eigen::Quaterniond R_upright = uprightOf(query, T);
      checked.push_back(check(uprightQuery(query, R_upright), {toUpright(query, T)}, reach_m)[0]);
      checked.back().T_map_query = R_frame_map * checked.back().T_map_query * R_upright;
    }
    return checked;
  }
  std::vector<Eigen::Isometry3d> upright;
  for (const Eigen::Isometry3d& T : T_map_query) upright.push_back(toUpright(query, T));
  std::vector<PoseCheck> checked = check(UprightQuery(query, query.gravity.upright).query, upright, reach_m);
  for (PoseCheck& p : checked) p.T_map_query = R_frame_map * p.T_map_query * query.gravity.upright;
  return checked;
}

/// The best place of a query in the frames of the caller, by one search and without a verdict; score 0 if there is none.
PoseCheck Localizer::Index::bestPlace(const Query& query, const ExpectedPose* expected) const {
  const Prepared prepared(*this, query, expected);
  PoseCheck best;
  Eigen::Quaterniond R_upright = prepared.R_upright;
  const auto take = [&](const Eigen::Isometry3d& T, double score) {
    best.T_map_query = gravity.upright.conjugate() * T * R_upright;
    best.evidence.score = score;
  };
  if (!upIsKnown(query)) {
    Localization answer;
    R_upright = free_path.localize(prepared.query(), prepared.priors, answer) * R_upright;
    if (!answer.hypotheses.empty()) take(answer.hypotheses[0].T_map_query, answer.hypotheses[0].score);
  } else if (takesPlacePath(query)) {
    if (const auto place = place_path->bestPlace(prepared.query(), planQuery(prepared.query()), prepared.priors)) take(poseOf(*place), place->pose.score);
  } else {
    const ObjectSearchResult found = object_path.search(prepared.query(), prepared.priors);
    if (!found.hypotheses.empty()) take(found.hypotheses[0].T_map_query, found.hypotheses[0].score);
  }
  return best;
}

Localization Localizer::Index::answerInScale(const Query& query, const ExpectedPose* expected) const {
  requireKnownLabels(map.labels, query.labels);
  if (!scales) return answerTo(query, expected, 0);
  if (options.method == "walks") throw UsageError("scale = " + options.scale + " needs the place search; method = walks has none");
  Stopwatch watch;
  const auto search = [&](const Query& scaled) { return bestPlace(scaled, expected); };
  const auto climb = [&](const Query& scaled, const Eigen::Isometry3d& T) { return checkAsGiven(scaled, {T}, INFINITY)[0]; };
  const FoundScale found = findScale(query, *scales, {search, climb});
  const double search_ms = watch.lap_ms();
  Localization answer = answerTo(scaledQuery(query, found.scale), expected, found.rival_score);
  answer.scale = found.scale;
  for (auto& [stage, ms] : answer.timing_ms) ms += stage == "total" ? search_ms : 0;
  answer.timing_ms.insert(answer.timing_ms.end() - 1, {"scale", search_ms});
  return answer;
}

Explanation Localizer::explain(const Query& given, const Localization& answer) const {
  Explanation explanation;
  if (answer.hypotheses.empty()) return explanation;
  const std::optional<Query> scaled = answer.scale == 1 ? std::nullopt : std::optional(scaledQuery(given, answer.scale));
  const Query& query = scaled ? *scaled : given;
  const SemanticMap& map = index_->map;
  const UprightQuery upright(query, index_->uprightOf(query, answer.T_map_query));
  const Eigen::Isometry3d T = index_->toUpright(query, answer.T_map_query);
  if (index_->takesPlacePath(query)) {
    explainSamples(*index_->places, map.plan, upright.query, index_->planQuery(upright.query), T, explanation);
  }
  explainVertices(map, upright.query, answer.kept, T, explanation);
  turn(index_->gravity.upright.conjugate(), explanation);
  return explanation;
}

std::vector<PoseCheck> Localizer::check(const Query& query, const std::vector<Eigen::Isometry3d>& T_map_query, double reach_m) const {
  return index_->checkAsGiven(query, T_map_query, reach_m);
}

Localization Localizer::describe(const Query& query, const PoseCheck& place) const {
  const Eigen::Quaterniond R_upright = index_->uprightOf(query, place.T_map_query);
  PoseCheck upright = place;
  upright.T_map_query = index_->toUpright(query, place.T_map_query);
  Localization answer;
  const Eigen::Quaterniond turn = index_->describe(UprightQuery(query, R_upright).query, upright, answer);
  leaveUprightFrames(index_->gravity.upright, turn * R_upright, query, answer);
  sayGravity(index_->gravity, query, answer);
  return answer;
}

}  // namespace xview
