// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <string>

#include "xview/types/localization.h"
#include "xview/types/option_field.h"

namespace xview::verify {

struct VerdictOptions {
  /// Share of right ones among answers with just this evidence, from which on an answer is
  /// accepted.
  double min_confidence = 0.98;
  double min_known_share = 0.15;  ///< share of the query that must lie where the map was seen
};

template <class Visitor>
void visit(VerdictOptions& o, Visitor&& field) {
  field("min_confidence", o.min_confidence, Range{0.5, 0.999999999},
        "confidence from which on an answer is accepted");
  field("min_known_share", o.min_known_share, Range{0, 1},
        "share of the query that must lie where the map was seen");
}

/// What a part of a query says for a place, and what it would say at a true pose [nats].
struct PartEvidence {
  double score = 0, expected = 0;
};

/// What speaks for and against the best place of one query, or of several together, by whatever
/// method and field it was found.
struct Evidence {
  double score = 0;        ///< of the best place [nats]
  double runner_up = 0;    ///< score of the best other place; what unseen area scores (0) if none
  double expected = 0;     ///< score that a true pose would have on average [nats]
  double known_share = 1;  ///< share of the query where the map knows anything
  PartEvidence standing;   ///< views: what stands upright
  std::array<PartEvidence, 2> sides;  ///< views: left and right of the way; zero if there is no way
  int windows = 1;  ///< queries that share no frame, whose evidence is summed here

  int vertices = 0;           ///< of the query, as the walks see it
  int kept = 0;               ///< correspondences that survive sample consensus at the best place
  int with_candidates = 0;    ///< vertices that had a candidate there
  double kept_by_chance = 0;  ///< how many of these would keep one at a wrong place
  std::optional<double> overlap;  ///< share of the points that meet the map after the refinement
};

struct Verdict {
  Status status = Status::rejected;
  double confidence = 0;
  std::string reason;
  Witnesses witnesses;
};

/// One formula and one scale for views, bare graphs, walks and sequences. Every witness says, as
/// log odds, how much more often its evidence comes with a right answer than with a wrong one, if
/// every other query is from elsewhere. Only the place decides so far; the others are reported.
///
/// The place witness grows with the logarithm of (s1 - s2) ln(s1 / s2), the lead of the best place
/// over the next one in nats, times how many times better it is: a lead of 60 nats is much over 30
/// and little over 600. It counts by the agreement, the share of a true pose's score that the place
/// has, the smallest of all, of what stands upright, and of either side of the way.
Verdict judge(const Evidence& evidence, const VerdictOptions& options);

}  // namespace xview::verify
