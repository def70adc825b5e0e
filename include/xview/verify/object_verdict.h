// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "xview/types/option_field.h"
#include "xview/verify/verdict.h"

namespace xview {

/// When a place found in a bare graph of objects is believed.
struct ObjectVerdictOptions {
  double max_false_alarms = 1e-3;  ///< queries from elsewhere that may look as good, per query
  double min_margin = 5;           ///< over the best other place [nats of a query of 60 vertices]
  double min_agreement = 0.3;      ///< 0 = like a typical wrong place, 1 = like a true pose
  double min_known_share = 0.15;   ///< share of the query that must lie where the map was seen
  int min_inliers = 4;  ///< vertices that must agree; two always do, as they make the pose
};

template <class Visitor>
void visit(ObjectVerdictOptions& o, Visitor&& field) {
  field("max_false_alarms", o.max_false_alarms, Range{1e-12, 1},
        "queries from elsewhere that may look as good, per query");
  field("min_margin", o.min_margin, Range{0, 1e6},
        "the best place must beat every other one by so much [nats, 60 vertices]");
  field("min_agreement", o.min_agreement, Range{0, 1},
        "how far from a typical wrong place (0) to a true one (1) the score must be");
  field("min_known_share", o.min_known_share, Range{0, 1},
        "share of the query that must lie where the map was seen");
  field("min_inliers", o.min_inliers, Range{0, 1e9},
        "vertices of the query that must agree with the map");
}

/// What speaks for and against the best place of an object search.
struct ObjectEvidence {
  double score = 0;            ///< of the best place [nats]
  double runner_up = 0;        ///< score of the best wrong place
  double typical_wrong = 0;    ///< mean score of the wrong places that were refined to the end
  double wrong_deviation = 0;  ///< standard deviation of their scores
  int wrong_places = 0;        ///< how many they were
  double expected = 0;         ///< score that a true pose would have [nats]
  double known_share = 0;      ///< share of the query in seen area
  int vertices = 0;            ///< of the query
  int inliers = 0;             ///< of these, with a partner in the map
};

/// How far scores of wrong places spread, 1 for a query of 60 vertices: they are sums over
/// vertices, so it grows with the root of their number, from 15 on.
double scoreSpread(int vertices);

/// Number of false alarms (a contrario): how many places as good as this one are to be expected
/// when a query from elsewhere is looked for in this map. The wrong places of the same search say
/// what is typical of this query in this map. The lead over them, and over the best of them, in
/// units of scoreSpread(), falls off exponentially for queries from elsewhere. The lead of a place
/// that does not agree like a true one counts from higher up, and the less the less it agrees.
double falseAlarms(const ObjectEvidence& evidence);

/// The confidence is the chance of the place to be right if as many queries come from the map as
/// from elsewhere. Accepted places have falseAlarms() <= max_false_alarms and meet the other needs.
Verdict judge(const ObjectEvidence& evidence, const ObjectVerdictOptions& options);

}  // namespace xview
