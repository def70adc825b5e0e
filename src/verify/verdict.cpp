// SPDX-License-Identifier: BSD-3-Clause
#include "xview/verify/verdict.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace xview {
namespace {

constexpr double kEqualShare =
    0.8;  ///< a runner-up with this share of the best score explains the query about equally well

/// 0.5 where the evidence just suffices, towards 1 as it grows.
double confidenceOf(double sufficiency) {
  const double cubed = std::pow(std::max(0.0, sufficiency), 3);
  return cubed / (1 + cubed);
}

constexpr std::size_t kTailPlaces = 8;
constexpr double kTailShare = 0.2;
/// Wrong answers for each right one, extrapolated to no evidence. Measured together with
/// VerdictOptions::false_alarm_nats, on windows of 15 to 60 m of simulated towns: right ones in
/// their own map against others, and against it without the right place, as if both were as
/// frequent.
constexpr double kWithoutEvidence = 25;
constexpr double kPartPrior = 15;         ///< nats; a small part says little
constexpr double kLeastAgreement = 0.01;  ///< so that needed margins are numbers

double margin(const ViewEvidence& e) { return e.score - e.runner_up; }

double agreement(const PartEvidence& part) {
  return (part.score + kPartPrior) / (std::max(0.0, part.expected) + kPartPrior);
}

/// Share of the score of a true pose, the smallest of all and of each part. A street that repeats
/// fits with its road but not with its houses, or with one side only.
double agreement(const ViewEvidence& e) {
  if (!(e.expected > 0)) return 0;
  return std::max(0.0, std::min({e.score / e.expected, agreement(e.standing), agreement(e.sides[0]),
                                 agreement(e.sides[1])}));
}

/// Evidence by which wrong answers become e times rarer [nats].
double unitOf(const ViewEvidence& e, const VerdictOptions& o) {
  const double usual = e.from_the_air ? o.aerial_false_alarm_nats : o.false_alarm_nats;
  return std::max(usual * std::sqrt(std::max(1, e.windows)),
                  kTailShare * tailScale(e.wrong_scores));
}

/// 0.003 and 2e-27, but 10 and not 1e+01.
std::string oneDigit(double value) {
  return value < 1 ? fmt::format("{:.1g}", value) : fmt::format("{:.0f}", value);
}

}  // namespace

double tailScale(const std::vector<double>& scores_best_first) {
  const std::size_t count = std::min(
      kTailPlaces, scores_best_first.size() - std::min<std::size_t>(1, scores_best_first.size()));
  if (count < 3) return 0;
  double excess = 0;
  for (std::size_t i = 0; i < count; ++i) excess += scores_best_first[i] - scores_best_first[count];
  return excess / static_cast<double>(count);
}

double expectedFalseAlarms(const ViewEvidence& e, const VerdictOptions& o) {
  const double evidence = std::max(0.0, margin(e)) * std::min(1.0, agreement(e));
  return kWithoutEvidence * std::exp(-evidence / unitOf(e, o));
}

double neededMargin(const ViewEvidence& e, const VerdictOptions& o) {
  const double allowed = 1 / o.min_confidence - 1;
  return std::max(0.0, std::log(kWithoutEvidence / allowed)) * unitOf(e, o) /
         std::clamp(agreement(e), kLeastAgreement, 1.0);
}

Verdict judge(const ViewEvidence& e, const VerdictOptions& o) {
  Verdict verdict;
  const double alarms = expectedFalseAlarms(e, o), agreed = agreement(e);
  const double share = e.expected > 0 ? e.score / e.expected : 0;
  const double lacking = std::min(share / std::max(1e-9, o.min_agreement),
                                  e.known_share / std::max(1e-9, o.min_known_share));
  const double by_evidence = std::isfinite(e.score) ? 1 / (1 + alarms) : 0;
  verdict.confidence = lacking >= 1
                           ? by_evidence
                           : std::max(0.0, std::min(by_evidence, 0.5 * lacking * o.min_confidence));
  if (verdict.confidence >= o.min_confidence) {
    verdict.status = Status::accepted;
    verdict.reason = fmt::format(
        "{:.0f} nats better than any other place, {:.0f} % of the agreement of a usual true pose: "
        "{} wrong answers per right one ({:.2g} allowed)",
        margin(e), 100 * agreed, oneDigit(std::max(alarms, 1e-99)), 1 / o.min_confidence - 1);
  } else if (e.known_share < o.min_known_share) {
    verdict.reason =
        fmt::format("only {:.0f} % of the query lies where the map was seen ({:.0f} % needed)",
                    100 * e.known_share, 100 * o.min_known_share);
  } else if (!(share >= o.min_agreement)) {
    verdict.reason =
        fmt::format("the best place has {:.0f} % of the score of a true pose ({:.0f} % needed)",
                    100 * std::max(0.0, share), 100 * o.min_agreement);
  } else if (e.runner_up >= kEqualShare * e.score) {
    verdict.status = Status::ambiguous;
    verdict.reason =
        fmt::format("two places explain the query about equally well ({:.0f} and {:.0f} nats)",
                    e.score, e.runner_up);
  } else {
    verdict.reason = fmt::format(
        "only {:.0f} nats better than any other place, {:.0f} % of the agreement of a usual true "
        "pose: {} wrong answers per right one ({:.2g} allowed)",
        margin(e), 100 * agreed, oneDigit(alarms), 1 / o.min_confidence - 1);
  }
  return verdict;
}

Verdict judge(const PlaceEvidence& e, double needed_margin, const VerdictOptions& o) {
  Verdict verdict;
  const double margin = e.score - e.runner_up;
  const double agreement = e.expected > 0 ? e.score / e.expected : 0;
  const double sufficiency =
      std::min({margin / std::max(1e-9, needed_margin), agreement / std::max(1e-9, o.min_agreement),
                e.known_share / std::max(1e-9, o.min_known_share)});
  verdict.confidence = confidenceOf(sufficiency);
  const bool agrees = agreement >= o.min_agreement && e.known_share >= o.min_known_share;
  if (sufficiency >= 1) {
    verdict.status = Status::accepted;
    verdict.reason = fmt::format(
        "{:.0f} nats better than any other place ({:.0f} needed), {:.0f} % of the score of a true "
        "pose",
        margin, needed_margin, 100 * agreement);
  } else if (agrees && e.runner_up >= kEqualShare * e.score) {
    verdict.status = Status::ambiguous;
    verdict.reason = fmt::format(
        "two places explain the query about equally well ({:.0f} and {:.0f} nats, {:.0f} apart "
        "needed)",
        e.score, e.runner_up, needed_margin);
  } else if (e.known_share < o.min_known_share) {
    verdict.reason =
        fmt::format("only {:.0f} % of the query lies where the map was seen ({:.0f} % needed)",
                    100 * e.known_share, 100 * o.min_known_share);
  } else if (agreement < o.min_agreement) {
    verdict.reason =
        fmt::format("the best place has {:.0f} % of the score of a true pose ({:.0f} % needed)",
                    100 * std::max(0.0, agreement), 100 * o.min_agreement);
  } else {
    verdict.reason =
        fmt::format("the best place is {:.0f} nats better than the next one ({:.0f} needed)",
                    margin, needed_margin);
  }
  return verdict;
}

Verdict judge(const ConsensusEvidence& e, const VerdictOptions& o) {
  Verdict verdict;
  // A row of houses fits another row: the inliers of wrong poses come in clusters and grow with the
  // query, up to about 22.
  const double chance = std::min(24.0, 5 + 0.18 * e.vertices);
  const double needed =
      std::max({o.min_inliers, chance, 2 * e.chance_inliers, o.min_inlier_ratio * e.runner_up});
  verdict.confidence = confidenceOf(e.inliers / needed);
  if (e.inliers >= needed) {
    verdict.status = Status::accepted;
    verdict.reason =
        fmt::format("{} of {} vertices agree ({:.0f} needed), {} in the next best place", e.inliers,
                    e.vertices, needed, e.runner_up);
  } else if (e.inliers >= o.min_inliers && e.runner_up >= kEqualShare * e.inliers) {
    verdict.status = Status::ambiguous;
    verdict.reason = fmt::format("two places agree equally well ({} and {} of {} vertices)",
                                 e.inliers, e.runner_up, e.vertices);
  } else {
    verdict.reason =
        fmt::format("{} of {} vertices agree, {:.0f} needed", e.inliers, e.vertices, needed);
  }
  return verdict;
}

}  // namespace xview
