// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/place_path.h"

#include <algorithm>
#include <cmath>

#include "pipeline/planar_pose.h"
#include "pipeline/pose_prior.h"
#include "pipeline/set_verdict.h"
#include "pipeline/vertex_pairs.h"
#include "xview/types/stopwatch.h"

namespace xview {
namespace {

constexpr double kPlaceMargin_m = 20;  ///< map vertices this far beyond the query still take part in walks

double radiusOf(const PlanQuery& query) {
  double radius = 0;
  for (const PlanQuery::Sample& s : query.fine) radius = std::max(radius, static_cast<double>(std::hypot(s.x, s.y)));
  return radius;
}

/// True if a place cannot be the other one a little further down the same street.
bool isFar(const PlacePose& a, const PlacePose& b) {
  constexpr double kFar_m = 20, kFar_rad = 0.8;
  return std::hypot(a.x - b.x, a.y - b.y) > kFar_m || std::abs(angleDifference(a.yaw, b.yaw)) > kFar_rad;
}

}  // namespace

/// Distinct verified places, best first.
struct PlacePath::RankedPlaces {
  struct Place {
    PlanHypothesis hypothesis;
    Proposer proposer;
  };

  /// Puts a verified pose where its score belongs; a place that is known already keeps the better pose.
  void insert(const PlanHypothesis& place, Proposer proposer) {
    const auto centreOf = [&](const PlanHypothesis& h) { return placeOfPoint(h.pose, query_centre); };
    const auto known = std::find_if(places.begin(), places.end(),
                                    [&](const Place& p) { return samePlace(centreOf(p.hypothesis), centreOf(place)); });
    if (known != places.end()) {
      if (place.pose.score <= known->hypothesis.pose.score) return;
      places.erase(known);
    }
    const auto at = std::upper_bound(places.begin(), places.end(), place, [](const PlanHypothesis& a, const Place& b) {
      return a.pose.score > b.hypothesis.pose.score;
    });
    places.insert(at, {place, proposer});
  }

  ViewEvidence evidence() const {
    ViewEvidence e;
    if (places.empty()) return e;
    const PlanHypothesis& best = places[0].hypothesis;
    e.score = best.pose.score;
    e.expected = best.expected;
    e.standing_score = best.standing_score;
    e.standing_expected = best.standing_expected;
    e.known_share = best.known_share;
    if (places.size() > 1) e.runner_up = std::max(0.0, places[1].hypothesis.pose.score);
    const PlacePose centre = placeOfPoint(best.pose, query_centre);
    for (const Place& p : places) {
      if (isFar(placeOfPoint(p.hypothesis.pose, query_centre), centre)) e.wrong_scores.push_back(p.hypothesis.pose.score);
    }
    return e;
  }

  Eigen::Vector2d query_centre;
  std::vector<Place> places;
};

void PlacePath::localize(const Query& query, const PlanQuery& plan_query, Localization& answer) const {
  Stopwatch watch;
  RankedPlaces ranked{plan_query.centre, {}};
  for (const PlanHypothesis& h : places_.search(plan_query, priorOfPoint(prior_, query, plan_query.centre), options_.threads)) {
    if (satisfies(prior_, query, poseOf(h))) ranked.places.push_back({h, Proposer::search});
  }
  answer.timing_ms.emplace_back("matching", watch.lap_ms());

  const WalkGraph walk_query = walks_.queryGraph(query.graph);
  WalkGraph part;
  answer.vertices = static_cast<int>(walk_query.graph.size());
  if (!ranked.places.empty()) {
    const PlacePose centre = placeOfPoint(ranked.places[0].hypothesis.pose, plan_query.centre);
    part = walks_.mapAround({centre.x, centre.y}, radiusOf(plan_query) + kPlaceMargin_m);
    if (options_.method == "auto") proposeByWalks(query, plan_query, walk_query, part, ranked, answer);
  }
  report(ranked, plan_query.viewpoint == Viewpoint::air, answer);
  if (answer.hypotheses.empty()) return;
  answer.kept = pairsUnderPose(walk_query, part, answer.hypotheses[0].T_map_query, options_.consensus.inlier_m);
  answer.hypotheses[0].inliers = answer.inliers = static_cast<int>(answer.kept.size());
}

void PlacePath::proposeByWalks(const Query& query, const PlanQuery& plan_query, const WalkGraph& walk_query, const WalkGraph& part,
                               RankedPlaces& ranked, Localization& answer) const {
  Stopwatch watch;
  const WalkProposals proposals = walks_.proposeIn(part, walk_query);
  for (const WalkProposal& p : proposals.poses) {
    const PlanHypothesis verified = places_.verify(plan_query, placeOf(p.T_map_query));
    if (satisfies(prior_, query, poseOf(verified))) ranked.insert(verified, Proposer::walks);
  }
  answer.putative = proposals.putative;
  answer.matches = static_cast<int>(proposals.putative.size());
  answer.timing_ms.emplace_back("descriptors", proposals.descriptors_ms);
  answer.timing_ms.emplace_back("rejection", watch.lap_ms() - proposals.descriptors_ms);
}

void PlacePath::report(const RankedPlaces& ranked, bool from_the_air, Localization& answer) const {
  const std::size_t count = std::min(ranked.places.size(), static_cast<std::size_t>(options_.places.hypotheses));
  for (std::size_t i = 0; i < count; ++i) {
    const auto& [h, proposer] = ranked.places[i];
    answer.hypotheses.push_back({poseOf(h), h.pose.score, h.objects_matched, proposer});
  }
  ViewEvidence evidence = ranked.evidence();
  evidence.from_the_air = from_the_air;
  setVerdict(judge(evidence, options_.verdict), answer);
}

}  // namespace xview
