// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "xview/types/localization.h"
#include "xview/types/option_field.h"

namespace xview {

struct VerdictOptions {
  double min_margin = 60;        ///< nats by which the best place must beat every other one
  double aerial_margin_factor = 1.8;  ///< times min_margin for views from the air: road layouts alone repeat between towns
  double min_agreement = 0.4;    ///< share of the score that a true pose would have
  double min_known_share = 0.15; ///< share of the query that must lie where the map was seen
  double min_object_margin = 19; ///< same as min_margin for graphs of 60 objects without surfaces
  double min_inliers = 8;        ///< method walks: vertices that must agree, more for large queries
  double min_inlier_ratio = 1.5; ///< method walks: times the inliers of the next best place
};

template <class Visitor>
void visit(VerdictOptions& o, Visitor&& field) {
  field("min_margin", o.min_margin, Range{0, 1e6}, "the best place must beat every other one by so much [nats]");
  field("aerial_margin_factor", o.aerial_margin_factor, Range{0, 1000}, "times min_margin for views from the air");
  field("min_agreement", o.min_agreement, Range{0, 1}, "share of the score of a true pose that is asked for");
  field("min_known_share", o.min_known_share, Range{0, 1}, "share of the query that must lie where the map was seen");
  field("min_object_margin", o.min_object_margin, Range{0, 1e6}, "same for bare graphs of objects [nats]");
  field("min_inliers", o.min_inliers, Range{3, 1e6}, "method walks: vertices that must agree");
  field("min_inlier_ratio", o.min_inlier_ratio, Range{1, 100}, "method walks: times the inliers of the next best place");
}

/// What speaks for and against the best pose of a place search.
struct PlaceEvidence {
  double score = 0;        ///< of the best place [nats]
  double runner_up = 0;    ///< score of the best other place; what unseen area scores (0) if there is none
  double expected = 0;     ///< score that a true pose would have [nats]
  double known_share = 0;  ///< share of the query in seen area
  int places = 0;          ///< distinct places that were compared
};

/// What speaks for and against the best pose of walks and sample consensus.
struct ConsensusEvidence {
  int inliers = 0;
  int runner_up = 0;       ///< inliers of the best other place
  int vertices = 0;        ///< of the query
  double chance_inliers = 0;  ///< inliers that a wrong pose has on average
};

struct Verdict {
  Status status = Status::rejected;
  double confidence = 0;
  std::string reason;
};

/// `needed_margin`: VerdictOptions::min_margin or min_object_margin.
Verdict judge(const PlaceEvidence& evidence, double needed_margin, const VerdictOptions& options);
Verdict judge(const ConsensusEvidence& evidence, const VerdictOptions& options);

}  // namespace xview
