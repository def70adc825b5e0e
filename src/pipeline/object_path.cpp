// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/object_path.h"

#include <algorithm>

#include "pipeline/pose_prior.h"
#include "pipeline/set_verdict.h"
#include "xview/types/stopwatch.h"

namespace xview {

const ObjectPlaceIndex& ObjectPath::index() const {
  std::call_once(made_, [&] { index_.emplace(map_.graph, map_.labels, options_.objects); });
  return *index_;
}

void ObjectPath::localize(const Query& query, Localization& answer) const {
  Stopwatch watch;
  ObjectSearchRequest request;
  request.threads = options_.threads;
  request.focus = query.poses.back().translation();
  request.prior = priorOfPoint(prior_, query, request.focus->head<2>());
  const ObjectSearchResult result = index().search(query.graph, request);
  answer.timing_ms.emplace_back("matching", watch.lap_ms());
  answer.vertices = result.vertices;
  answer.matches = result.poses;
  const auto count = std::min(result.hypotheses.size(), static_cast<std::size_t>(options_.places.hypotheses));
  for (std::size_t i = 0; i < count; ++i) {
    const ObjectHypothesis& h = result.hypotheses[i];
    answer.hypotheses.push_back({h.T_map_query, h.score, static_cast<int>(h.inliers.size()), Proposer::search});
  }
  PlaceEvidence evidence;
  if (count > 0) {
    const ObjectHypothesis& best = result.hypotheses[0];
    evidence = {best.score, result.wrong.count > 0 ? std::max(0.0, result.wrong.best) : 0.0, best.expected, best.known_share};
    answer.kept = best.inliers;
    answer.inliers = static_cast<int>(best.inliers.size());
  }
  setVerdict(judge(evidence, neededMargin(options_.verdict.min_object_margin, result.vertices), options_.verdict), answer);
}

}  // namespace xview
