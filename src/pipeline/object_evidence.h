// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>

#include "xview/search/search.h"
#include "xview/verify/object_verdict.h"

namespace xview {

/// What a search in an object field says for and against its best place.
inline ObjectEvidence evidenceOf(const search::SearchResult& result) {
  ObjectEvidence evidence;
  evidence.vertices = static_cast<int>(result.vertices);
  if (result.places.empty()) return evidence;
  const search::PlaceHypothesis& best = result.places[0];
  evidence.score = best.score();
  evidence.expected = best.expected;
  evidence.known_share = best.known_share;
  evidence.inliers = best.matched;
  const std::vector<double> wrong = result.wrongScores();
  evidence.wrong_places = static_cast<int>(wrong.size());
  if (wrong.empty()) return evidence;
  double sum = 0, squares = 0;
  for (const double score : wrong) {
    sum += score;
    squares += score * score;
  }
  const auto count = static_cast<double>(wrong.size());
  evidence.runner_up = wrong[0];
  evidence.typical_wrong = sum / count;
  evidence.wrong_deviation =
      std::sqrt(std::max(0.0, squares / count - evidence.typical_wrong * evidence.typical_wrong));
  return evidence;
}

}  // namespace xview
