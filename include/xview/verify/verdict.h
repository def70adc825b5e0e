// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

#include "xview/types/localization.h"
#include "xview/types/option_field.h"

namespace xview {

struct VerdictOptions {
  double min_confidence =
      0.98;  ///< views from above: share of right ones among answers with just this evidence
  double false_alarm_nats = 6;  ///< by so much more evidence, wrong places become e times rarer
  double aerial_false_alarm_nats =
      8.5;                        ///< same from the air: layouts of streets repeat between towns
  double min_agreement = 0.4;     ///< share of the score that a true pose would have
  double min_known_share = 0.15;  ///< share of the query that must lie where the map was seen
  double min_inliers = 8;  ///< method walks: vertices that must agree, more for large queries
  double min_inlier_ratio = 1.5;  ///< method walks: times the inliers of the next best place
};

template <class Visitor>
void visit(VerdictOptions& o, Visitor&& field) {
  field("min_confidence", o.min_confidence, Range{0.5, 0.999999999},
        "confidence from which on an answer is accepted; method walks: 0.5");
  field("false_alarm_nats", o.false_alarm_nats, Range{0.1, 1e6},
        "by so much more evidence, wrong places become e times rarer [nats]");
  field("aerial_false_alarm_nats", o.aerial_false_alarm_nats, Range{0.1, 1e6},
        "same for views from the air [nats]");
  field("min_agreement", o.min_agreement, Range{0, 1},
        "share of the score of a true pose that is asked for");
  field("min_known_share", o.min_known_share, Range{0, 1},
        "share of the query that must lie where the map was seen");
  field("min_inliers", o.min_inliers, Range{3, 1e6}, "method walks: vertices that must agree");
  field("min_inlier_ratio", o.min_inlier_ratio, Range{1, 100},
        "method walks: times the inliers of the next best place");
}

/// What a part of a query says for a place, and what it would say at a true pose [nats].
struct PartEvidence {
  double score = 0, expected = 0;
};

/// What speaks for and against a place over one or several queries.
struct PlaceEvidence {
  double score = 0;  ///< of the best place [nats]
  double runner_up =
      0;  ///< score of the best other place; what unseen area scores (0) if there is none
  double expected = 0;     ///< score that a true pose would have [nats]
  double known_share = 0;  ///< share of the query in seen area
  PartEvidence standing;   ///< views from above: what stands upright
  std::array<PartEvidence, 2>
      sides;  ///< views from above: left and right of the way; zero if there is no way
};

/// The same of a search over views from above, or of several searches together.
struct ViewEvidence : PlaceEvidence {
  bool from_the_air = false;
  int windows = 1;  ///< queries that share no frame, whose evidence is summed here
  std::vector<double>
      wrong_scores;  ///< of places that are far from the best one, best first [nats]
};

/// Scale of the upper tail of scores of wrong places: mean excess of the best 8 over the ninth
/// [nats]. Wrong scores fall off exponentially, so a wrong place is ahead of the next one by more
/// than m with probability exp(-m / scale). 0 if there are fewer than 4.
double tailScale(const std::vector<double>& scores_best_first);

/// Wrong answers for each right one among answers with just so much evidence, if every other query
/// is of a place that the map does not hold. The evidence is the margin over the next place times
/// the agreement, which is the share of a true pose's score that the place has (the smallest of
/// all, of what stands upright, and of either side of the way; at most 1), in units of
/// options.false_alarm_nats (from the air aerial_false_alarm_nats), or of a share of the tail scale
/// if wrong places of this map score more differently.
double expectedFalseAlarms(const ViewEvidence& evidence, const VerdictOptions& options);

/// The margin with which a place would be accepted that agrees like this one, or by 1 % [nats].
double neededMargin(const ViewEvidence& evidence, const VerdictOptions& options);

/// What speaks for and against the best pose of walks and sample consensus.
struct ConsensusEvidence {
  int inliers = 0;
  int runner_up = 0;          ///< inliers of the best other place
  int vertices = 0;           ///< of the query
  double chance_inliers = 0;  ///< inliers that a wrong pose has on average
};

struct Verdict {
  Status status = Status::rejected;
  double confidence = 0;
  std::string reason;
};

/// Confidence is 1 / (1 + expected false alarms): what share of answers with just this evidence is
/// right.
Verdict judge(const ViewEvidence& evidence, const VerdictOptions& options);
Verdict judge(const PlaceEvidence& evidence, double needed_margin, const VerdictOptions& options);
Verdict judge(const ConsensusEvidence& evidence, const VerdictOptions& options);

}  // namespace xview
