// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/object_path.h"

#include <algorithm>
#include <cmath>

#include "pipeline/object_evidence.h"
#include "pipeline/set_verdict.h"
#include "xview/types/stopwatch.h"

namespace xview {

const ObjectPlaceIndex& ObjectPath::index() const {
  std::call_once(made_, [&] { index_.emplace(map_.graph, map_.labels, options_.objects); });
  return *index_;
}

ObjectSearchResult ObjectPath::search(const Query& query, const Priors& priors) const {
  ObjectSearchRequest request;
  request.threads = options_.threads;
  request.hypotheses = options_.places.hypotheses;
  request.focus = query.poses.back().translation();
  request.prior = priorOfPoint(priors, query, request.focus->head<2>());
  return index().search(query.graph, request);
}

void ObjectPath::localize(const Query& query, const Priors& priors, double rival_score,
                          Localization& answer) const {
  Stopwatch watch;
  ObjectSearchResult result = search(query, priors);
  result.wrong.best = std::max(result.wrong.best, rival_score);
  answer.timing_ms.emplace_back("matching", watch.lap_ms());
  report(result, answer);
}

void ObjectPath::report(const ObjectSearchResult& result, Localization& answer) const {
  answer.vertices = result.vertices;
  answer.matches = result.poses;
  const auto count =
      std::min(result.hypotheses.size(), static_cast<std::size_t>(options_.places.hypotheses));
  for (std::size_t i = 0; i < count; ++i) {
    const ObjectHypothesis& h = result.hypotheses[i];
    answer.hypotheses.push_back(
        {h.T_map_query, h.score, static_cast<int>(h.inliers.size()), Proposer::search});
  }
  if (count > 0) {
    answer.kept = result.hypotheses[0].inliers;
    answer.inliers = static_cast<int>(answer.kept.size());
  }
  setVerdict(judge(evidenceOf(result), options_.object_verdict), answer);
}

PoseCheck ObjectPath::check(const Query& query, const Eigen::Isometry3d& T_map_query,
                            double reach_m) const {
  const Eigen::Vector3d sensor = query.poses.back().translation();
  ObjectSearchRequest request;
  request.focus = sensor;
  const ObjectHypothesis h = index().score(query.graph, {T_map_query}, request).at(0);
  PoseCheck place{h.T_map_query, {h.score, 0, h.expected, h.known_share, {}, {}}, 0};
  place.needed_margin =
      options_.sequence.min_object_margin * scoreSpread(static_cast<int>(query.graph.size()));
  if ((h.T_map_query * sensor - T_map_query * sensor).head<2>().norm() > reach_m) {
    place.T_map_query = T_map_query;
    place.evidence.score = 0;  // the objects agree with another pose, not with this one
  }
  return place;
}

}  // namespace xview
