// SPDX-License-Identifier: BSD-3-Clause
#include "xview/localizer.h"

#include <fmt/core.h>

#include <cmath>
#include <optional>

#include "pipeline/explain.h"
#include "pipeline/gravity.h"
#include "pipeline/planar_pose.h"
#include "pipeline/scale_search.h"
#include "pipeline/upright_frame.h"
#include "pipeline/upright_localizer.h"
#include "pipeline/view_point.h"
#include "xview/types/error.h"
#include "xview/types/prior_text.h"
#include "xview/types/stopwatch.h"

namespace xview {
namespace {

void requireKnownLabels(const LabelSet& map, const LabelSet& query) {
  for (const auto& [id, info] : query.classes()) {
    const ClassInfo* known = map.find(id);
    if (known && known->name != info.name) {
      throw Error("label set '" + query.name() + "'",
                  fmt::format("class {} is '{}' here but '{}' in the map (label set '{}')", id,
                              info.name, known->name, map.name()));
    }
  }
}

/// What was assumed about up, for people; before what the place that was found says about it.
void sayGravity(const Gravity& map, const Query& query, Localization& answer) {
  const bool turned = map.turned() || query.gravity.turned();
  if (answer.gravity == GravityUse::aligned && turned) answer.gravity = GravityUse::levelled;
  answer.gravity_reason =
      "query: " + query.gravity.reason + "; map: " + map.reason + answer.gravity_reason;
}

}  // namespace

/// Frames as callers have them around a localizer of upright ones.
struct Localizer::Index {
  struct Prepared;
  Index(const SemanticMap& semantic_map, const Options& all_options)
      : gravity(gravityOf(semantic_map, all_options.gravity)),
        turned(uprightMap(semantic_map, gravity.upright)),
        options(all_options),
        prior(parsePrior(options.prior)),
        scales(parseScale("scale", options.scale)),
        upright(turned ? *turned : semantic_map, gravity.sigma_rad, options) {}

  Localization answerFromViewPoint(const Query& query, const ExpectedPose* expected) const;
  Localization answerTo(const Query& query, const ExpectedPose* expected, double rival_score) const;
  Localization answerInScale(const Query& query, const ExpectedPose* expected) const;
  PoseCheck bestPlace(const Query& query, const ExpectedPose* expected) const;
  std::vector<PoseCheck> check(const Query& query,
                               const std::vector<Eigen::Isometry3d>& T_map_query,
                               double reach_m) const;

  bool upIsKnown(const Query& query) const { return gravity.known && query.gravity.known; }
  /// Turns the query upright; a pose of it says how, if nothing else does.
  Eigen::Quaterniond uprightOf(const Query& query, const Eigen::Isometry3d& T_map_query) const {
    if (upIsKnown(query)) return query.gravity.upright;
    return uprightBy(T_map_query.linear().transpose() *
                     (gravity.upright.conjugate() * Eigen::Vector3d::UnitZ()));
  }
  /// Between upright frames; a query levelled on the map is turned by a little more than that.
  Eigen::Isometry3d toUpright(const Query& query, const Eigen::Isometry3d& T_map_query) const {
    return gravity.upright * T_map_query * uprightOf(query, T_map_query).conjugate();
  }
  /// Gravity-aligned, and right for the last sensor.
  Eigen::Isometry3d toAligned(const Query& query, const Eigen::Isometry3d& T_map_query) const {
    return alignedAbout(uprightOf(query, T_map_query) * query.poses.back().translation(),
                        toUpright(query, T_map_query));
  }

  const Gravity gravity;  ///< of the caller's map
  const std::optional<SemanticMap> turned;
  const Options options;
  const PlacePrior prior;
  const std::optional<ScaleRange> scales;
  const UprightLocalizer upright;
};

Localizer::Localizer(const SemanticMap& map, const Options& options)
    : index_(std::make_unique<Index>(map, options)) {}
Localizer::~Localizer() = default;

Localization Localizer::localize(const Query& query) const {
  return index_->answerFromViewPoint(query, nullptr);
}

Localization Localizer::localize(const Query& query, const ExpectedPose& expected) const {
  return index_->answerFromViewPoint(query, &expected);
}

Localization Localizer::Index::answerFromViewPoint(const Query& query,
                                                   const ExpectedPose* expected) const {
  const std::optional<Query> centred =
      query.cloud.empty() ? std::nullopt : seenFromItsCentre(query);
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
      : R_upright(expected ? index.uprightOf(given, expected->T_map_query) : given.gravity.upright),
        upright(given, R_upright),
        priors{index.prior} {
    if (!expected) return;
    const Eigen::Isometry3d T = index.toAligned(given, expected->T_map_query);
    priors.push_back(priorAround({T, expected->radius_m, expected->yaw_rad}, upright.query));
  }
  const Query& query() const { return upright.query; }

  Eigen::Quaterniond R_upright;
  UprightQuery upright;
  Priors priors;
};

/// In the frames of the caller, with all times.
Localization Localizer::Index::answerTo(const Query& query, const ExpectedPose* expected,
                                        double rival_score) const {
  Stopwatch watch;
  Localization answer;
  const Prepared prepared(*this, query, expected);
  const Eigen::Quaterniond turn =
      upIsKnown(query) ? upright.localize(prepared.query(), prepared.priors, rival_score, answer)
                       : upright.localizeFreely(prepared.query(), prepared.priors, answer);
  // A pose that is expected comes from a fix; one that a user believes in is to be doubted.
  if (!expected && (prior.near || prior.heading))
    upright.doubtPriors(prepared.query(), prepared.priors, answer);
  leaveUprightFrames(gravity.upright, turn * prepared.R_upright, query, answer);
  sayGravity(gravity, query, answer);
  double total = watch.lap_ms();
  for (const auto& [stage, ms] : query.timing_ms) total += ms;
  answer.timing_ms.insert(answer.timing_ms.begin(), query.timing_ms.begin(), query.timing_ms.end());
  answer.timing_ms.emplace_back("total", total);
  return answer;
}

/// In the frames of the caller.
std::vector<PoseCheck> Localizer::Index::check(const Query& query,
                                               const std::vector<Eigen::Isometry3d>& T_map_query,
                                               double reach_m) const {
  const Eigen::Quaterniond R_frame_map = gravity.upright.conjugate();
  if (!upIsKnown(query)) {  // each pose has an up of its own
    std::vector<PoseCheck> checked;
    for (const Eigen::Isometry3d& T : T_map_query) {
      const Eigen::Quaterniond R_upright = uprightOf(query, T);
      checked.push_back(
          upright.check(uprightQuery(query, R_upright), {toUpright(query, T)}, reach_m)[0]);
      checked.back().T_map_query = R_frame_map * checked.back().T_map_query * R_upright;
    }
    return checked;
  }
  std::vector<Eigen::Isometry3d> poses;
  for (const Eigen::Isometry3d& T : T_map_query) poses.push_back(toUpright(query, T));
  std::vector<PoseCheck> checked =
      upright.check(UprightQuery(query, query.gravity.upright).query, poses, reach_m);
  for (PoseCheck& p : checked) p.T_map_query = R_frame_map * p.T_map_query * query.gravity.upright;
  return checked;
}

/// The best place of a query in the frames of the caller, by one search and without a verdict;
/// score 0 if there is none.
PoseCheck Localizer::Index::bestPlace(const Query& query, const ExpectedPose* expected) const {
  const Prepared prepared(*this, query, expected);
  PoseCheck best;
  Eigen::Quaterniond R_upright = prepared.R_upright;
  if (upIsKnown(query)) {
    best = upright.bestPlace(prepared.query(), prepared.priors);
  } else {
    Localization answer;
    R_upright = upright.freePath().localize(prepared.query(), prepared.priors, answer) * R_upright;
    if (answer.hypotheses.empty()) return best;
    best.T_map_query = answer.hypotheses[0].T_map_query;
    best.evidence.score = answer.hypotheses[0].score;
  }
  best.T_map_query = gravity.upright.conjugate() * best.T_map_query * R_upright;
  return best;
}

Localization Localizer::Index::answerInScale(const Query& query,
                                             const ExpectedPose* expected) const {
  requireKnownLabels(upright.labels(), query.labels);
  if (!scales) return answerTo(query, expected, 0);
  if (options.method == "walks")
    throw UsageError("scale = " + options.scale +
                     " needs the place search; method = walks has none");
  Stopwatch watch;
  const auto search = [&](const Query& scaled) { return bestPlace(scaled, expected); };
  const auto climb = [&](const Query& scaled, const Eigen::Isometry3d& T) {
    return check(scaled, {T}, INFINITY)[0];
  };
  const FoundScale found = findScale(query, *scales, {search, climb});
  const double search_ms = watch.lap_ms();
  Localization answer = answerTo(scaledQuery(query, found.scale), expected, found.rival_score);
  answer.scale = found.scale;
  for (auto& [stage, ms] : answer.timing_ms) ms += stage == "total" ? search_ms : 0;
  answer.timing_ms.insert(answer.timing_ms.end() - 1, {"scale", search_ms});
  return answer;
}

Explanation Localizer::explain(const Query& given, const Localization& answer) const {
  if (answer.hypotheses.empty()) return {};
  const std::optional<Query> scaled =
      answer.scale == 1 ? std::nullopt : std::optional(scaledQuery(given, answer.scale));
  const Query& query = scaled ? *scaled : given;
  const UprightQuery upright(query, index_->uprightOf(query, answer.T_map_query));
  Explanation explanation = index_->upright.explain(upright.query, answer.kept,
                                                    index_->toAligned(query, answer.T_map_query));
  turn(index_->gravity.upright.conjugate(), explanation);
  return explanation;
}

std::vector<PoseCheck> Localizer::check(const Query& query,
                                        const std::vector<Eigen::Isometry3d>& T_map_query,
                                        double reach_m) const {
  return index_->check(query, T_map_query, reach_m);
}

bool Localizer::priorAllows(const Query& query, const Eigen::Isometry3d& T_map_query) const {
  const UprightQuery upright(query, index_->uprightOf(query, T_map_query));
  return satisfies({index_->prior}, upright.query, index_->toAligned(query, T_map_query));
}

Localization Localizer::describe(const Query& query, const PoseCheck& place) const {
  const Eigen::Quaterniond R_upright = index_->uprightOf(query, place.T_map_query);
  PoseCheck upright = place;
  upright.T_map_query = index_->toAligned(query, place.T_map_query);
  Localization answer;
  const Eigen::Quaterniond turn =
      index_->upright.describe(UprightQuery(query, R_upright).query, upright, answer);
  leaveUprightFrames(index_->gravity.upright, turn * R_upright, query, answer);
  sayGravity(index_->gravity, query, answer);
  return answer;
}

}  // namespace xview
