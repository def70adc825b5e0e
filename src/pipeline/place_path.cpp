// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/place_path.h"

#include <fmt/core.h>

#include <algorithm>

#include "pipeline/planar_pose.h"
#include "pipeline/set_verdict.h"
#include "pipeline/vertex_pairs.h"
#include "xview/types/stopwatch.h"

namespace xview {
namespace {

constexpr double kClearMargins = 5;  ///< so many needed margins are no coincidence anywhere
constexpr double kPlaceMargin_m =
    20;  ///< map vertices this far beyond the query still take part in walks

PlaceEvidence evidenceFor(const PlanHypothesis& h) {
  PlaceEvidence e;
  e.score = h.pose.score;
  e.expected = h.expected;
  e.known_share = h.known_share;
  e.standing = {h.standing.score, h.standing.expected};
  for (std::size_t side = 0; side < e.sides.size(); ++side)
    e.sides[side] = {h.sides[side].score, h.sides[side].expected};
  return e;
}

}  // namespace

/// Distinct verified places, best first.
struct PlacePath::RankedPlaces {
  struct Place {
    PlanHypothesis hypothesis;
    Proposer proposer;
  };

  /// Puts a verified pose where its score belongs; a place that is known already keeps the better
  /// pose.
  void insert(const PlanHypothesis& place, Proposer proposer) {
    const auto centreOf = [&](const PlanHypothesis& h) {
      return placeOfPoint(h.pose, query_centre);
    };
    const auto known = std::find_if(places.begin(), places.end(), [&](const Place& p) {
      return samePlace(centreOf(p.hypothesis), centreOf(place));
    });
    if (known != places.end()) {
      if (place.pose.score <= known->hypothesis.pose.score) return;
      places.erase(known);
    }
    const auto at = std::upper_bound(places.begin(), places.end(), place,
                                     [](const PlanHypothesis& a, const Place& b) {
                                       return a.pose.score > b.hypothesis.pose.score;
                                     });
    places.insert(at, {place, proposer});
  }

  ViewEvidence evidence() const {
    ViewEvidence e;
    if (places.empty()) return e;
    const PlanHypothesis& best = places[0].hypothesis;
    static_cast<PlaceEvidence&>(e) = evidenceFor(best);
    e.runner_up = std::max(best_outside, places.size() > 1 ? places[1].hypothesis.pose.score : 0);
    const PlacePose centre = placeOfPoint(best.pose, query_centre);
    for (const Place& p : places) {
      if (isFar(placeOfPoint(p.hypothesis.pose, query_centre), centre))
        e.wrong_scores.push_back(p.hypothesis.pose.score);
    }
    return e;
  }

  Eigen::Vector2d query_centre;
  std::vector<Place> places;
  double best_outside = 0;  ///< score of the best place next to what the priors allow: better than
                            ///< all inside, it refutes them; or of a rival
};

WalkGraph PlacePath::mapPart(const PlanQuery& plan_query,
                             const Eigen::Isometry3d& T_map_query) const {
  const PlacePose centre = placeOfPoint(placeOf(T_map_query), plan_query.centre);
  return walks_.mapAround({centre.x, centre.y}, radiusOf(plan_query.fine) + kPlaceMargin_m);
}

double PlacePath::marginInFullAgreement(const PlanQuery& plan_query) const {
  ViewEvidence perfect;
  perfect.score = perfect.expected = 1;
  perfect.from_the_air = plan_query.viewpoint == Viewpoint::air;
  return neededMargin(perfect, options_.verdict);
}

void PlacePath::localize(const Query& query, const PlanQuery& plan_query, const Priors& priors,
                         double rival_score, Localization& answer) const {
  Stopwatch watch;
  const Priors around = widened(priors);
  RankedPlaces ranked{plan_query.centre, {}, rival_score};
  for (const PlanHypothesis& h : places_.search(
           plan_query, priorOfPoint(priors, query, plan_query.centre), options_.threads)) {
    if (satisfies(priors, query, poseOf(h)))
      ranked.places.push_back({h, Proposer::search});
    else if (satisfies(around, query, poseOf(h)))
      ranked.best_outside = std::max(ranked.best_outside, h.pose.score);
  }
  answer.timing_ms.emplace_back("matching", watch.lap_ms());

  const WalkGraph walk_query = walks_.queryGraph(query.graph);
  WalkGraph part;
  answer.vertices = static_cast<int>(walk_query.graph.size());
  if (!ranked.places.empty()) {
    part = mapPart(plan_query, poseOf(ranked.places[0].hypothesis));
    if (options_.method == "auto" && !areOnePlace(priors))
      proposeByWalks(query, plan_query, walk_query, part, priors, ranked, answer);
  }
  report(ranked, plan_query.viewpoint == Viewpoint::air, answer);
  if (answer.hypotheses.empty()) return;
  answer.kept = pairsUnderPose(walk_query, part, answer.hypotheses[0].T_map_query,
                               options_.consensus.inlier_m);
  answer.hypotheses[0].inliers = answer.inliers = static_cast<int>(answer.kept.size());
}

std::optional<PlanHypothesis> PlacePath::bestPlace(const Query& query, const PlanQuery& plan_query,
                                                   const Priors& priors) const {
  for (const PlanHypothesis& h : places_.search(
           plan_query, priorOfPoint(priors, query, plan_query.centre), options_.threads)) {
    if (satisfies(priors, query, poseOf(h))) return h;
  }
  return std::nullopt;
}

void PlacePath::proposeByWalks(const Query& query, const PlanQuery& plan_query,
                               const WalkGraph& walk_query, const WalkGraph& part,
                               const Priors& priors, RankedPlaces& ranked,
                               Localization& answer) const {
  Stopwatch watch;
  const WalkProposals proposals = walks_.proposeIn(part, walk_query);
  for (const WalkProposal& p : proposals.poses) {
    const PlanHypothesis verified = places_.verify(plan_query, placeOf(p.T_map_query));
    if (satisfies(priors, query, poseOf(verified))) ranked.insert(verified, Proposer::walks);
  }
  answer.putative = proposals.putative;
  answer.matches = static_cast<int>(proposals.putative.size());
  answer.timing_ms.emplace_back("descriptors", proposals.descriptors_ms);
  answer.timing_ms.emplace_back("rejection", watch.lap_ms() - proposals.descriptors_ms);
}

void PlacePath::report(const RankedPlaces& ranked, bool from_the_air, Localization& answer) const {
  const std::size_t count =
      std::min(ranked.places.size(), static_cast<std::size_t>(options_.places.hypotheses));
  for (std::size_t i = 0; i < count; ++i) {
    const auto& [h, proposer] = ranked.places[i];
    answer.hypotheses.push_back({poseOf(h), h.pose.score, h.objects_matched, proposer});
  }
  ViewEvidence evidence = ranked.evidence();
  evidence.from_the_air = from_the_air;
  setVerdict(judge(evidence, options_.verdict), answer);
}

void PlacePath::refuteFromOutside(const Query& query, const PlanQuery& plan_query,
                                  const Priors& priors, Localization& answer) const {
  const double inside = answer.hypotheses[0].score, needed = marginInFullAgreement(plan_query);
  if (!answer.accepted() || inside >= kClearMargins * needed) return;
  Stopwatch watch;
  for (const PlanHypothesis& h : places_.search(plan_query, {}, options_.threads)) {
    if (satisfies(priors, query, poseOf(h)) || h.pose.score < inside + needed) continue;
    takeBack(fmt::format("a place outside of the prior is {:.0f} nats better than the best one "
                         "inside",
                         h.pose.score - inside),
             answer);
    break;
  }
  answer.timing_ms.emplace_back("prior", watch.lap_ms());
}

PoseCheck PlacePath::check(const Query& query, const PlanQuery& plan_query,
                           const Eigen::Isometry3d& T_map_query, double reach_m) const {
  const Eigen::Vector3d sensor = query.poses.back().translation();
  const PlacePose given = placeOf(alignedAbout(sensor, T_map_query));
  const PlanHypothesis h = places_.verify(plan_query, given);
  PoseCheck place{poseOf(h), evidenceFor(h), 0};
  if ((place.T_map_query * sensor - T_map_query * sensor).head<2>().norm() > reach_m) {
    place.T_map_query = T_map_query;
    place.evidence = evidenceFor(places_.describe(plan_query, given));
  }
  return place;
}

void PlacePath::findPairs(const Query& query, const PlanQuery& plan_query,
                          Localization& answer) const {
  const WalkGraph walk_query = walks_.queryGraph(query.graph);
  Hypothesis& best = answer.hypotheses[0];
  answer.vertices = static_cast<int>(walk_query.graph.size());
  answer.kept = pairsUnderPose(walk_query, mapPart(plan_query, best.T_map_query), best.T_map_query,
                               options_.consensus.inlier_m);
  best.inliers = answer.inliers = static_cast<int>(answer.kept.size());
}

}  // namespace xview
