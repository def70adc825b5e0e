// SPDX-License-Identifier: BSD-3-Clause
#include "xview/verify/verdict.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace xview::verify {
namespace {

/// Log odds of the place witness per factor e of its statistic, and the statistic at even odds:
/// logistic regression over windows of 15 to 60 m of clean and noisy worlds and over queries from
/// elsewhere, counted as if both were as frequent.
constexpr double kOddsPerFactorE = 2.6, kEvenOdds = 6;
/// What a wrong place may score by chance, so that small scores say little [nats].
constexpr double kNoise_nats = 2;
/// A runner-up with this share of the best score explains the query about equally well.
constexpr double kEqualShare = 0.8;
/// Below this agreement a place is a stranger's, not one of two.
constexpr double kLeastAgreement = 0.2;
/// Added to scores of parts, of which a small one says little [nats].
constexpr double kPartPrior_nats = 15;
/// Chance that a vertex keeps a correspondence at the true place (search, detection of objects).
constexpr double kKeptIfTrue = 0.62;
/// Share of points that meet the map: at this share a right and a wrong answer are as likely, and
/// log odds per share. Only reported.
constexpr double kEvenOverlap = 0.35, kOddsPerOverlap = 12;

/// (s1 - s2) ln(s1 / s2) with the noise of wrong scores, which grows with the root of the number of
/// windows.
double leadStatistic(const Evidence& e) {
  const double noise = kNoise_nats * std::sqrt(std::max(1, e.windows));
  const double best = e.score + noise, next = std::max(0.0, e.runner_up) + noise;
  if (!(best > next)) return 0;
  return (best - next) * std::log(best / next) / std::sqrt(std::max(1, e.windows));
}

double agreementOf(const PartEvidence& part) {
  return (part.score + kPartPrior_nats) / (std::max(0.0, part.expected) + kPartPrior_nats);
}

/// Share of the score of a true pose, the smallest of all and of each part, in [0, 1]. A street
/// that repeats fits with its road but not with its houses, or with one side only.
double agreementOf(const Evidence& e) {
  if (!(e.expected > 0)) return 1;  // nobody knows what a true pose scores: walks
  return std::clamp(std::min({e.score / e.expected, agreementOf(e.standing),
                              agreementOf(e.sides[0]), agreementOf(e.sides[1])}),
                    0.0, 1.0);
}

double placeOdds(const Evidence& e) {
  const double statistic = leadStatistic(e) * agreementOf(e);
  return kOddsPerFactorE * std::log(std::max(1e-9, statistic) / kEvenOdds);
}

/// Binomial: how much likelier so many kept correspondences are at the true place than by chance.
double correspondenceOdds(const Evidence& e) {
  if (e.with_candidates == 0) return 0;
  const double n = e.with_candidates, k = std::min<double>(e.kept, n);
  const double by_chance = std::clamp(e.kept_by_chance / n, 0.01, 0.99);
  return k * std::log(kKeptIfTrue / by_chance) +
         (n - k) * std::log((1 - kKeptIfTrue) / (1 - by_chance));
}

Witnesses witnessesOf(const Evidence& e) {
  Witnesses w;
  w.place = placeOdds(e);
  w.correspondences = correspondenceOdds(e);
  if (e.overlap) w.dense = kOddsPerOverlap * (*e.overlap - kEvenOverlap);
  return w;
}

}  // namespace

Verdict judge(const Evidence& e, const VerdictOptions& o) {
  Verdict verdict;
  if (!std::isfinite(e.score) || e.score <= 0) {
    verdict.reason = "nothing in the map agrees with the query";
    return verdict;
  }
  verdict.witnesses = witnessesOf(e);
  verdict.confidence = 1 / (1 + std::exp(-verdict.witnesses.place));
  const bool unseen = e.known_share < o.min_known_share;
  if (unseen) verdict.confidence *= 0.5 * e.known_share / o.min_known_share;
  const double agreement = agreementOf(e);
  const std::string lead =
      fmt::format("the best place has {:.0f} nats, the next one {:.0f}", e.score, e.runner_up);
  if (unseen) {
    verdict.reason =
        fmt::format("only {:.0f} % of the query lies where the map was seen ({:.0f} % needed)",
                    100 * e.known_share, 100 * o.min_known_share);
  } else if (verdict.confidence >= o.min_confidence) {
    verdict.status = Status::accepted;
    verdict.reason =
        lead + fmt::format(", {:.0f} % of the agreement of a usual true pose", 100 * agreement);
  } else if (e.runner_up >= kEqualShare * e.score && agreement >= kLeastAgreement) {
    verdict.status = Status::ambiguous;
    verdict.reason =
        fmt::format("two places explain the query about equally well ({:.0f} and {:.0f} nats)",
                    e.score, e.runner_up);
  } else {
    verdict.reason = lead + fmt::format(": right with {:.3g} % at most, {:.4g} % needed",
                                        100 * verdict.confidence, 100 * o.min_confidence);
  }
  return verdict;
}

}  // namespace xview::verify
