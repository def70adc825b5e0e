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

PlaceEvidence evidenceFor(const search::PlaceHypothesis& h) {
  PlaceEvidence e;
  e.score = h.score();
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
    search::PlaceHypothesis hypothesis;
    Proposer proposer;
  };

  /// Puts a verified pose where its score belongs; a place that is known already keeps the better
  /// pose.
  void insert(const search::PlaceHypothesis& place, Proposer proposer) {
    const auto known = std::find_if(places.begin(), places.end(), [&](const Place& p) {
      return samePlace(p.hypothesis.centre, place.centre);
    });
    if (known != places.end()) {
      if (place.score() <= known->hypothesis.score()) return;
      places.erase(known);
    }
    const auto at = std::upper_bound(places.begin(), places.end(), place,
                                     [](const search::PlaceHypothesis& a, const Place& b) {
                                       return a.score() > b.hypothesis.score();
                                     });
    places.insert(at, {place, proposer});
  }

  ViewEvidence evidence() const {
    ViewEvidence e;
    if (places.empty()) return e;
    const search::PlaceHypothesis& best = places[0].hypothesis;
    static_cast<PlaceEvidence&>(e) = evidenceFor(best);
    e.runner_up = std::max(best_outside, places.size() > 1 ? places[1].hypothesis.score() : 0);
    for (const Place& p : places) {
      if (isFar(p.hypothesis.centre, best.centre)) e.wrong_scores.push_back(p.hypothesis.score());
    }
    return e;
  }

  std::vector<Place> places;
  double best_outside = 0;  ///< score of the best place next to what the priors allow: better than
                            ///< all inside, it refutes them; or of a rival
};

WalkGraph PlacePath::mapPart(const search::FieldQuery& in_field,
                             const Eigen::Isometry3d& T_map_query) const {
  const Eigen::Vector3d centre = T_map_query * in_field.centre();
  return walks_.mapAround({centre.x(), centre.y()}, in_field.radius() + kPlaceMargin_m);
}

double PlacePath::marginInFullAgreement(const Query& query) const {
  ViewEvidence perfect;
  perfect.score = perfect.expected = 1;
  perfect.from_the_air = query.plan.aerial;
  return neededMargin(perfect, options_.verdict);
}

void PlacePath::localize(const Query& query, const search::FieldQuery& in_field,
                         const Priors& priors, double rival_score, Localization& answer) const {
  Stopwatch watch;
  const search::SearchResult found =
      search::search(in_field, framePriors(priors, query), options_.places, options_.threads);
  RankedPlaces ranked{{}, std::max(rival_score, found.outside)};
  for (const search::PlaceHypothesis& h : found.places)
    ranked.places.push_back({h, Proposer::search});
  answer.timing_ms.emplace_back("matching", watch.lap_ms());

  const WalkGraph walk_query = walks_.queryGraph(query.graph);
  WalkGraph part;
  answer.vertices = static_cast<int>(walk_query.graph.size());
  if (!ranked.places.empty()) {
    part = mapPart(in_field, ranked.places[0].hypothesis.T_map_query);
    if (options_.method == "auto" && !areOnePlace(priors))
      proposeByWalks(query, in_field, walk_query, part, priors, ranked, answer);
  }
  report(ranked, query.plan.aerial, answer);
  if (answer.hypotheses.empty()) return;
  answer.kept = pairsUnderPose(walk_query, part, answer.hypotheses[0].T_map_query,
                               options_.consensus.inlier_m);
  answer.hypotheses[0].inliers = answer.inliers = static_cast<int>(answer.kept.size());
}

std::optional<search::PlaceHypothesis> PlacePath::bestPlace(const Query& query,
                                                            const search::FieldQuery& in_field,
                                                            const Priors& priors) const {
  search::SearchResult found =
      search::search(in_field, framePriors(priors, query), options_.places, options_.threads);
  if (found.places.empty()) return std::nullopt;
  return std::move(found.places[0]);
}

void PlacePath::proposeByWalks(const Query& query, const search::FieldQuery& in_field,
                               const WalkGraph& walk_query, const WalkGraph& part,
                               const Priors& priors, RankedPlaces& ranked,
                               Localization& answer) const {
  Stopwatch watch;
  const WalkProposals proposals = walks_.proposeIn(part, walk_query);
  for (const WalkProposal& p : proposals.poses) {
    const search::PlaceHypothesis verified = in_field.verify(p.T_map_query);
    if (satisfies(priors, query, verified.T_map_query)) ranked.insert(verified, Proposer::walks);
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
    answer.hypotheses.push_back({h.T_map_query, h.score(), h.matched, proposer});
  }
  ViewEvidence evidence = ranked.evidence();
  evidence.from_the_air = from_the_air;
  setVerdict(judge(evidence, options_.verdict), answer);
}

void PlacePath::refuteFromOutside(const Query& query, const search::FieldQuery& in_field,
                                  const Priors& priors, Localization& answer) const {
  const double inside = answer.hypotheses[0].score, needed = marginInFullAgreement(query);
  if (!answer.accepted() || inside >= kClearMargins * needed) return;
  Stopwatch watch;
  const search::SearchResult found =
      search::search(in_field, {}, options_.places, options_.threads);
  for (const search::PlaceHypothesis& h : found.places) {
    if (satisfies(priors, query, h.T_map_query) || h.score() < inside + needed) continue;
    takeBack(fmt::format("a place outside of the prior is {:.0f} nats better than the best one "
                         "inside",
                         h.score() - inside),
             answer);
    break;
  }
  answer.timing_ms.emplace_back("prior", watch.lap_ms());
}

PoseCheck PlacePath::check(const Query& query, const search::FieldQuery& in_field,
                           const Eigen::Isometry3d& T_map_query, double reach_m) const {
  const Eigen::Vector3d sensor = query.poses.back().translation();
  const Eigen::Isometry3d given = alignedAbout(sensor, T_map_query);
  const search::PlaceHypothesis h = in_field.verify(given);
  PoseCheck place{h.T_map_query, evidenceFor(h), 0};
  if ((place.T_map_query * sensor - T_map_query * sensor).head<2>().norm() > reach_m) {
    place.T_map_query = T_map_query;
    place.evidence = evidenceFor(in_field.describe(given));
  }
  return place;
}

void PlacePath::findPairs(const Query& query, const search::FieldQuery& in_field,
                          Localization& answer) const {
  const WalkGraph walk_query = walks_.queryGraph(query.graph);
  Hypothesis& best = answer.hypotheses[0];
  answer.vertices = static_cast<int>(walk_query.graph.size());
  answer.kept = pairsUnderPose(walk_query, mapPart(in_field, best.T_map_query), best.T_map_query,
                               options_.consensus.inlier_m);
  best.inliers = answer.inliers = static_cast<int>(answer.kept.size());
}

}  // namespace xview
