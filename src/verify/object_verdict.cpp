// SPDX-License-Identifier: BSD-3-Clause
#include "xview/verify/object_verdict.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace xview {
namespace {

constexpr double kEqualShare =
    0.8;  // a runner-up with this share of the best score explains the query about equally well
constexpr double kUsualVertices = 60;  // of a query
constexpr int kFewVertices = 15;       // the lead of a smaller query is worth no more for that
constexpr int kFewWrong = 10;          // the mean of fewer wrong places says little
constexpr double kMarginShare = 0.5;   // of the margin, in the lead
// Deviations above the mean of wrong places from which the lead of a place counts: what the best of
// some dozens may well have for one that agrees like a true place, more for any other.
constexpr double kUsualDeviations = 2, kRareDeviations = 3;
constexpr double kAgreesLikeTrue = 2. / 3;
// Fitted to 4200 queries from elsewhere in 360 maps of 700 vertices of generated towns; larger maps
// and dense graphs of drives raise fewer.
constexpr double kLeadOfOneAlarm = 1, kLeadPerFactorE = 3.25;  // [nats]
// Density of false alarms over that of right places, at the same lead.
constexpr double kAlarmsPerRightPlace = 16;

/// As if the query had 60 vertices.
double normalized(double nats, int vertices) { return nats / scoreSpread(vertices); }

bool knowsWrongPlaces(const ObjectEvidence& e) { return e.wrong_places >= kFewWrong; }

/// Without wrong places to compare with, unseen area is one: it scores 0.
double runnerUpOf(const ObjectEvidence& e) {
  return knowsWrongPlaces(e) ? e.runner_up : std::max(0.0, e.runner_up);
}

double marginOf(const ObjectEvidence& e) { return normalized(e.score - runnerUpOf(e), e.vertices); }

/// How far ahead of what wrong places of this search may well score, and of the best of them.
double leadOf(const ObjectEvidence& e, double deviations) {
  if (!knowsWrongPlaces(e)) return marginOf(e);
  const double usual_wrong = e.typical_wrong + deviations * e.wrong_deviation;
  return normalized(e.score - usual_wrong, e.vertices) + kMarginShare * marginOf(e);
}

/// Score of a place that explains nothing.
double leastOf(const ObjectEvidence& e) {
  return knowsWrongPlaces(e) ? std::min(0.0, e.typical_wrong) : 0;
}

/// 0 for a place that explains nothing, 1 for a true one.
double agreementOf(const ObjectEvidence& e) {
  const double least = leastOf(e);
  return e.expected > least ? (e.score - least) / (e.expected - least) : 0;
}

bool areAboutEqual(const ObjectEvidence& e) {
  const double least = leastOf(e);
  return runnerUpOf(e) - least >= kEqualShare * (e.score - least);
}

/// How much of a need is met, in [0, 1]; NaN meets nothing.
double met(double value, double needed) {
  if (value >= needed) return 1;
  return value > 0 ? value / needed : 0;
}

}  // namespace

double scoreSpread(int vertices) {
  return std::sqrt(std::max(kFewVertices, vertices) / kUsualVertices);
}

double falseAlarms(const ObjectEvidence& e) {
  const double agreement = std::clamp(agreementOf(e), 0.0, 1.0);
  double lead = leadOf(e, kRareDeviations) * std::sqrt(agreement);
  if (agreement >= kAgreesLikeTrue) lead = std::max(lead, leadOf(e, kUsualDeviations));
  return lead > kLeadOfOneAlarm ? std::exp((kLeadOfOneAlarm - lead) / kLeadPerFactorE) : 1;
}

Verdict judge(const ObjectEvidence& e, const ObjectVerdictOptions& o) {
  const double alarms = falseAlarms(e);
  const double agreement = agreementOf(e);
  const double needs = met(agreement, o.min_agreement) * met(e.known_share, o.min_known_share) *
                       met(e.inliers, o.min_inliers);
  const double margin_met = met(marginOf(e), o.min_margin);
  Verdict verdict;
  verdict.confidence = needs * margin_met / (1 + kAlarmsPerRightPlace * alarms);
  if (e.known_share < o.min_known_share) {
    verdict.reason =
        fmt::format("only {:.0f} % of the query lies where the map was seen ({:.0f} % needed)",
                    100 * e.known_share, 100 * o.min_known_share);
  } else if (e.inliers < o.min_inliers) {
    verdict.reason =
        fmt::format("{} of {} vertices agree, {} needed", e.inliers, e.vertices, o.min_inliers);
  } else if (needs < 1) {
    verdict.reason = fmt::format(
        "the best place is {:.0f} % of the way from a wrong one to a true one ({:.0f} % needed)",
        100 * std::max(0.0, agreement), 100 * o.min_agreement);
  } else if (margin_met < 1 || (alarms > o.max_false_alarms && areAboutEqual(e))) {
    verdict.status = Status::ambiguous;
    verdict.reason =
        fmt::format("two places explain the query about equally well ({:.0f} and {:.0f} nats)",
                    e.score, runnerUpOf(e));
  } else if (alarms > o.max_false_alarms) {
    verdict.reason = fmt::format(
        "{:.2g} false alarms expected, {:.2g} allowed: {:.0f} nats, {:.0f} for a typical wrong "
        "place, {:.0f} for a true one",
        alarms, o.max_false_alarms, e.score, e.typical_wrong, e.expected);
  } else {
    verdict.status = Status::accepted;
    verdict.reason = fmt::format(
        "{:.2g} false alarms expected, {:.2g} allowed; {:.0f} nats, {:.0f} for the next place",
        alarms, o.max_false_alarms, e.score, runnerUpOf(e));
  }
  return verdict;
}

}  // namespace xview
