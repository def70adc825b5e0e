// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/upright_localizer.h"

#include <fmt/core.h>

#include <cmath>

#include "pipeline/explain.h"
#include "pipeline/upright_frame.h"
#include "xview/types/error.h"

namespace xview {
namespace {

constexpr double kFreeSigma_rad = 0.3;  ///< up by nothing but the pose that was found

std::vector<Eigen::Vector3d> trajectoryOf(const SemanticMap& map) {
  std::vector<Eigen::Vector3d> path;
  for (const Keyframe& k : map.keyframes) path.push_back(k.T_map_sensor.translation());
  return path;
}

std::unique_ptr<const search::Field> surfaceField(const SemanticMap& map, const Options& options) {
  if (options.method == "walks" || map.plan.known.empty()) return nullptr;
  return search::makeSurfaceField(map.plan, trajectoryOf(map), options.places, options.threads);
}

void sayLevelled(const LevelledQuery& level, Localization& answer) {
  constexpr double kDegrees = 180 / M_PI;
  if (answer.gravity == GravityUse::aligned) answer.gravity = GravityUse::levelled;
  answer.gravity_reason =
      fmt::format("; turned by {:.1f} +- {:.1f} deg onto the ground of the map",
                  Eigen::AngleAxisd(level.turn).angle() * kDegrees, level.up_sigma_rad * kDegrees);
}

}  // namespace

UprightLocalizer::UprightLocalizer(const SemanticMap& map, double map_up_sigma_rad,
                                   const Options& options)
    : map_(map),
      map_up_sigma_rad_(map_up_sigma_rad),
      options_(options),
      walks_(map.graph, map.labels, options),
      surfaces_(surfaceField(map, options)),
      walk_path_(map, walks_, options),
      place_path_(walks_, options),
      object_path_(map, options),
      free_path_(walks_, object_path_, options),
      refinement_(map, options) {}

std::unique_ptr<search::FieldQuery> UprightLocalizer::inField(const Query& query) const {
  if (!surfaces_) return nullptr;
  std::vector<Eigen::Vector2d> way;
  for (const Eigen::Isometry3d& T : query.poses) way.emplace_back(T.translation().head<2>());
  return surfaces_->prepare({&query.plan, &query.graph, way, query.poses.back().translation()});
}

double UprightLocalizer::upSigma(const Query& query) const {
  return std::hypot(map_up_sigma_rad_, query.gravity.sigma_rad);
}

Eigen::Quaterniond UprightLocalizer::localize(const Query& query, const Priors& priors,
                                              double rival_score, Localization& answer) const {
  const std::unique_ptr<search::FieldQuery> in_field = inField(query);
  if (options_.method == "walks")
    walk_path_.localize(query, priors, answer);
  else if (takesPlacePath(query))
    place_path_.localize(query, *in_field, priors, rival_score, answer);
  else
    object_path_.localize(query, priors, rival_score, answer);
  return finish(query, in_field.get(), priors, answer);
}

Eigen::Quaterniond UprightLocalizer::localizeFreely(const Query& query, const Priors& priors,
                                                    Localization& answer) const {
  answer.gravity = GravityUse::free;
  const Eigen::Quaterniond upright = free_path_.localize(query, priors, answer);
  Query turned = uprightQuery(query, upright);
  turned.gravity.sigma_rad = kFreeSigma_rad;
  return finish(turned, nullptr, priors, answer) * upright;
}

void UprightLocalizer::doubtPriors(const Query& query, const Priors& priors,
                                   Localization& answer) const {
  if (answer.accepted() && takesPlacePath(query))
    place_path_.refuteFromOutside(query, *inField(query), priors, answer);
}

Eigen::Quaterniond UprightLocalizer::describe(const Query& query, const PoseCheck& place,
                                              Localization& answer) const {
  const std::unique_ptr<search::FieldQuery> in_field = inField(query);
  answer.hypotheses.push_back({place.T_map_query, place.evidence.score, 0, Proposer::search});
  if (takesPlacePath(query)) place_path_.findPairs(query, *in_field, answer);
  return refine(query, in_field.get(), answer);
}

Eigen::Quaterniond UprightLocalizer::finish(const Query& query, const search::FieldQuery* in_field,
                                            const Priors& priors, Localization& answer) const {
  const Eigen::Quaterniond turn = refine(query, in_field, answer);
  refuseOutside(priors, UprightQuery(query, turn).query, answer);
  return turn;
}

/// Levels the query on the ground of the map, if that is needed, and refines its pose.
Eigen::Quaterniond UprightLocalizer::refine(const Query& query, const search::FieldQuery* in_field,
                                            Localization& answer) const {
  if (answer.hypotheses.empty()) return Eigen::Quaterniond::Identity();
  const auto level = levelled(query, in_field, answer.hypotheses[0].T_map_query);
  if (!level) {
    refinement_.refine(query, in_field, upSigma(query), answer);
    return Eigen::Quaterniond::Identity();
  }
  for (Hypothesis& h : answer.hypotheses) h.T_map_query = h.T_map_query * level->turn.conjugate();
  answer.hypotheses[0].T_map_query = level->T_map_query;
  sayLevelled(*level, answer);
  refinement_.refine(level->query, level->in_field.get(), level->up_sigma_rad, answer);
  return level->turn;
}

std::optional<LevelledQuery> UprightLocalizer::levelled(
    const Query& query, const search::FieldQuery* in_field,
    const Eigen::Isometry3d& T_map_query) const {
  if (options_.gravity == "aligned" || !in_field || in_field->empty()) return std::nullopt;
  return levelOnMap(*surfaces_, query, *in_field, T_map_query, upSigma(query), options_);
}

PoseCheck UprightLocalizer::bestPlace(const Query& query, const Priors& priors) const {
  PoseCheck best;
  if (takesPlacePath(query)) {
    const auto place = place_path_.bestPlace(query, *inField(query), priors);
    if (!place) return best;
    best.T_map_query = place->T_map_query;
    best.evidence.score = place->score();
    return best;
  }
  const search::SearchResult found = object_path_.search(query, priors);
  if (found.places.empty()) return best;
  best.T_map_query = found.places[0].T_map_query;
  best.evidence.score = found.places[0].score();
  return best;
}

std::vector<PoseCheck> UprightLocalizer::check(const Query& query,
                                               const std::vector<Eigen::Isometry3d>& T_map_query,
                                               double reach_m) const {
  if (options_.method == "walks")
    throw UsageError("method = walks cannot say what speaks for a given pose");
  const std::unique_ptr<search::FieldQuery> in_field = inField(query);
  std::vector<PoseCheck> checked;
  for (const Eigen::Isometry3d& T : T_map_query) {
    checked.push_back(takesPlacePath(query) ? place_path_.check(query, *in_field, T, reach_m)
                                            : object_path_.check(query, T, reach_m));
  }
  return checked;
}

Explanation UprightLocalizer::explain(const Query& query, const std::vector<Correspondence>& kept,
                                      const Eigen::Isometry3d& T_map_query) const {
  Explanation explanation;
  if (takesPlacePath(query))
    explainSamples(map_.plan, query, *inField(query), T_map_query, explanation);
  explainVertices(map_, query, kept, T_map_query, explanation);
  return explanation;
}

}  // namespace xview
