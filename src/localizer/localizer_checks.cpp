// SPDX-License-Identifier: BSD-3-Clause
// What is asked of a pose that was found otherwise: what speaks for it, and why.
#include <fmt/core.h>

#include <cmath>

#include "base/pose.h"
#include "localizer/explain.h"
#include "localizer/level_on_map.h"
#include "localizer/localizer_index.h"
#include "localizer/storeys_of_map.h"
#include "map/contents.h"
#include "place/sound_input.h"
#include "verdict/verdict.h"
#include "xview/base/budget.h"
#include "xview/base/error.h"
#include "xview/base/semantic_place.h"

namespace xview {

std::vector<PoseCheck> PlaceIndex::check(const Query& given,
                                         const std::vector<Eigen::Isometry3d>& poses,
                                         double reach_m) const {
  if (!method.scores_poses)
    throw UsageError("method = walks cannot say what speaks for a given pose");
  std::vector<PoseCheck> checked;
  std::unique_ptr<const AlignedQuery> query;
  std::unique_ptr<const search::FieldQuery> in_field;
  for (const Eigen::Isometry3d& T_given : poses) {
    askBudget("the places known before");
    const Eigen::Quaterniond R_up = alignmentOf(given, T_given);
    if (!query || !upIsKnown(given)) {  // a query of unknown up has another one for each pose
      query = std::make_unique<AlignedQuery>(given, FrameHypothesis{R_up, 1});
      in_field = fields.prepare(**query);
    }
    const Eigen::Isometry3d T = toAligned(given, T_given);
    const Eigen::Vector3d sensor = (*query)->poses.back().translation();
    const search::PlaceHypothesis best = in_field->verify(T);
    const double moved_m = (best.T_map_query * sensor - T * sensor).head<2>().norm();
    if (moved_m > reach_m)
      checked.push_back({T_given, evidenceOf(in_field->describe(T))});
    else
      checked.push_back(
          {gravity.alignment.conjugate() * best.T_map_query * R_up, evidenceOf(best)});
  }
  return checked;
}

/// Pose, covariance and correspondences for a place that was found otherwise.
Localization PlaceIndex::describe(const Query& given, const PoseCheck& place) const {
  FrameHypothesis frame{alignmentOf(given, place.T_map_query), 1};
  const AlignedQuery query(given, frame);
  Candidates found;
  found.in_field = fields.prepare(*query);
  found.places.push_back(found.in_field->describe(toAligned(given, place.T_map_query)));
  Localization answer;
  matchVertices(*query, found, answer.timing_ms);
  RegisteredPlaces registered = registerPlaces(*query, found, answer);
  report(found, 1, answer);
  answer.hypotheses[0].score = place.evidence.score;
  verdict::Evidence evidence = evidenceOf(found, registered);
  addStoreys(found, map, evidence);
  adoptRefinedPose(registered, answer);
  frame.R_up = registered.turn * frame.R_up;
  answer.statistics = verdict::statisticsOf(evidence);
  leaveAlignedFrames(given, frame, answer);
  return answer;
}

Explanation PlaceIndex::explain(const Query& given, const Localization& answer) const {
  const AlignedQuery scaled(given, {Eigen::Quaterniond::Identity(), answer.scale});
  const AlignedQuery query(*scaled, {alignmentOf(*scaled, answer.T_map_query), 1});
  const Eigen::Isometry3d T = toAligned(*scaled, answer.T_map_query);
  Explanation explanation;
  if (fields.isView(*query)) {
    const auto in_field = fields.prepare(*query);
    explainSamples(map::viewOf(map), *query, *in_field, T, explanation);
  }
  explainVertices(map, *query, answer.kept, T, explanation);
  turn(gravity.alignment.conjugate(), explanation);
  return explanation;
}

std::vector<PoseCheck> Localizer::check(const Query& query,
                                        const std::vector<Eigen::Isometry3d>& T_map_query,
                                        double reach_m) const {
  if (std::isnan(reach_m)) throw UsageError("reach_m is no number");
  const PlaceIndex& index = indexFor(query);
  std::vector<Eigen::Isometry3d> poses;
  for (const Eigen::Isometry3d& T : T_map_query) {
    requireNear("T_map_query", T, size_);
    poses.push_back(scaled(1 / size_, T));
  }
  std::vector<PoseCheck> checked =
      index.check(*QueryInMap(query, map().labels, size_, names_), poses, reach_m / size_);
  for (PoseCheck& place : checked) scaleLengths(size_, place.T_map_query);
  return checked;
}

std::vector<Localization> Localizer::judge(
    const Query& query, const std::vector<Eigen::Isometry3d>& T_map_query) const {
  constexpr double kNear_m = 2;  ///< a registration moves what is right that far, at most
  if (!scoresPoses()) throw UsageError("method = walks cannot say what speaks for a given pose");
  for (const Eigen::Isometry3d& T : T_map_query) requireNear("T_map_query", T, size_);
  const Localization own = localize(query);
  const Eigen::Vector3d sensor = query.poses.back().translation();
  std::vector<Localization> all;
  for (const Eigen::Isometry3d& T : T_map_query) {
    const auto offOf = [&](const Localization& answer) {
      return answer.hypotheses.empty() ? 0 : (answer.T_map_query * sensor - T * sensor).norm();
    };
    const bool is_own = !own.hypotheses.empty() && offOf(own) <= kNear_m * size_ &&
                        rotationBetween(own.T_map_query, T) < kSamePlace_rad;
    Localization answer =
        is_own ? own
               : localizeNear(query, {}, &T, own.hypotheses.empty() ? 0 : own.hypotheses[0].score);
    if (const double off_m = offOf(answer); answer.accepted() && off_m > kNear_m * size_)
      verdict::refuse(ReasonCode::contradicted,
                      fmt::format("the best pose around is {:.1f} m from the given one", off_m),
                      answer);
    all.push_back(std::move(answer));
  }
  return all;
}

verdict::Verdict Localizer::judge(const verdict::Evidence& evidence) const {
  map();  // is there one?
  return index_->judged(evidence);
}

bool Localizer::priorAllows(const Query& given, const Eigen::Isometry3d& T_given) const {
  map();  // is there one?
  requireNear("T_map_query", T_given, size_);
  const QueryInMap query(given, given.labels, size_, names_);  // a prior knows no classes
  const Eigen::Isometry3d T = scaled(1 / size_, T_given);
  const Eigen::Isometry3d upright = index_->alignmentOf(*query, T) * query->poses.back();
  return satisfies({index_->prior}, query->sensor, index_->toAligned(*query, T) * upright);
}

Localization Localizer::describe(const Query& query, const PoseCheck& place) const {
  requireNear("T_map_query", place.T_map_query, size_);
  const PlaceIndex& index = indexFor(query);
  const PoseCheck canonical{scaled(1 / size_, place.T_map_query), place.evidence};
  return inMetres(index.describe(*QueryInMap(query, map().labels, size_, names_), canonical),
                  size_);
}

Explanation Localizer::explain(const Query& query, const Localization& answer) const {
  if (answer.hypotheses.empty()) return {};
  const PlaceIndex& index = indexFor(query);
  requireNear("T_map_query", answer.T_map_query, size_);
  requireAnswerTo(query, map(), answer);
  Localization canonical = answer;
  if (size_ != kTownScale) scaleLengths(1 / size_, canonical);
  Explanation explanation =
      index.explain(*QueryInMap(query, map().labels, size_, names_), canonical);
  scaleLengths(size_, explanation);
  return explanation;
}

}  // namespace xview
