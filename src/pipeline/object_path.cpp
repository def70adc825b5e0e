// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/object_path.h"

#include <algorithm>

#include "pipeline/pose_prior.h"
#include "pipeline/set_verdict.h"
#include "xview/types/stopwatch.h"

namespace xview {

namespace {

ObjectEvidence evidenceOf(const ObjectSearchResult& result) {
  ObjectEvidence evidence;
  evidence.vertices = result.vertices;
  if (result.hypotheses.empty()) return evidence;
  const ObjectHypothesis& best = result.hypotheses[0];
  evidence.score = best.score;
  evidence.expected = best.expected;
  evidence.known_share = best.known_share;
  evidence.runner_up = result.wrong.best;
  evidence.typical_wrong = result.wrong.mean;
  evidence.wrong_deviation = result.wrong.deviation;
  evidence.wrong_places = result.wrong.count;
  return evidence;
}

}  // namespace

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
  if (count > 0) {
    answer.kept = result.hypotheses[0].inliers;
    answer.inliers = static_cast<int>(answer.kept.size());
  }
  setVerdict(judge(evidenceOf(result), options_.object_verdict), answer);
}

}  // namespace xview
