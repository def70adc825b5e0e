// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/object_path.h"

#include <algorithm>
#include <cmath>

#include "pipeline/object_evidence.h"
#include "pipeline/set_verdict.h"
#include "xview/types/stopwatch.h"

namespace xview {

std::unique_ptr<search::FieldQuery> ObjectPath::inField(const Query& query) const {
  std::call_once(
      made_, [&] { field_ = search::makeObjectField(map_.graph, map_.labels, options_.places); });
  return field_->prepare({nullptr, &query.graph, {}, query.poses.back().translation()});
}

search::SearchResult ObjectPath::search(const Query& query, const Priors& priors) const {
  return search::search(*inField(query), framePriors(priors, query), options_.places,
                        options_.threads);
}

void ObjectPath::localize(const Query& query, const Priors& priors, double rival_score,
                          Localization& answer) const {
  Stopwatch watch;
  const search::SearchResult result = search(query, priors);
  answer.timing_ms.emplace_back("matching", watch.lap_ms());
  report(result, rival_score, answer);
}

void ObjectPath::report(const search::SearchResult& result, double rival_score,
                        Localization& answer) const {
  answer.vertices = static_cast<int>(result.vertices);
  answer.matches = result.poses;
  const auto count =
      std::min(result.places.size(), static_cast<std::size_t>(options_.places.hypotheses));
  for (std::size_t i = 0; i < count; ++i) {
    const search::PlaceHypothesis& h = result.places[i];
    answer.hypotheses.push_back({h.T_map_query, h.score(), h.matched, Proposer::search});
  }
  if (count > 0) {
    answer.kept = result.places[0].pairs;
    answer.inliers = result.places[0].matched;
  }
  ObjectEvidence evidence = evidenceOf(result);
  evidence.runner_up = std::max(evidence.runner_up, rival_score);
  setVerdict(judge(evidence, options_.object_verdict), answer);
}

PoseCheck ObjectPath::check(const Query& query, const Eigen::Isometry3d& T_map_query,
                            double reach_m) const {
  const Eigen::Vector3d sensor = query.poses.back().translation();
  const search::PlaceHypothesis h = inField(query)->verify(T_map_query);
  PoseCheck place{h.T_map_query, {h.score(), 0, h.expected, h.known_share, {}, {}}, 0};
  place.needed_margin =
      options_.sequence.min_object_margin * scoreSpread(static_cast<int>(query.graph.size()));
  if ((h.T_map_query * sensor - T_map_query * sensor).head<2>().norm() > reach_m) {
    place.T_map_query = T_map_query;
    place.evidence.score = 0;  // the objects agree with another pose, not with this one
  }
  return place;
}

}  // namespace xview
