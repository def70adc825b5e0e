// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "xview/match/object_places.h"
#include "xview/verify/object_verdict.h"

namespace xview {

/// What a search says for and against its best place.
inline ObjectEvidence evidenceOf(const ObjectSearchResult& result) {
  ObjectEvidence evidence;
  evidence.vertices = result.vertices;
  if (result.hypotheses.empty()) return evidence;
  const ObjectHypothesis& best = result.hypotheses[0];
  evidence.score = best.score;
  evidence.expected = best.expected;
  evidence.known_share = best.known_share;
  evidence.inliers = static_cast<int>(best.inliers.size());
  evidence.runner_up = result.wrong.best;
  evidence.typical_wrong = result.wrong.mean;
  evidence.wrong_deviation = result.wrong.deviation;
  evidence.wrong_places = result.wrong.count;
  return evidence;
}

}  // namespace xview
