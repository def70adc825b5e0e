// SPDX-License-Identifier: BSD-3-Clause
#include "verdict/verdict.h"

#include <fmt/core.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <tuple>
#include <utility>

namespace xview::verdict {
namespace {

using std::string_literals::operator""s;

/// Score of wrong places under the null hypothesis, so that small scores say little [nats].
constexpr double kNoise_nats = 2;
/// Added to the scores of parts of a place: small scores say little [nats].
constexpr double kPartPrior_nats = 15;
constexpr double kLeast = 0.02;    ///< shares of less are all the same
constexpr double kLikeTrue = 0.8;  ///< score ratio of a usual true place
/// Thresholds of the inlier ratio above null, at about even odds: absolute where the map overlap is
/// set, else as a share of the self-consistency of the query. A wrong place among similar rooms has
/// half of it, the right one three quarters.
constexpr double kInlierRatioThreshold = 0.15, kSelfConsistencyThreshold = 0.4;
constexpr double kUsualSelfConsistency = 0.6;  ///< where it could not be measured
/// Weights of the dense score of a place: inlier ratio above null, map overlap, free-space
/// violation and logarithm of the score; and the dense score of a place that was not verified,
/// beside that of its score. BEV samples lie half as far above null at right places as points do.
constexpr double kDenseScorePerAboveNull = 14, kDenseScorePerAboveNullOfBev = 20,
                 kDenseScorePerMapOverlap = 7, kDenseScorePerFreeSpace = 2,
                 kDenseScorePerLogScore = 2, kDenseScoreUnconverged = -4,
                 kDenseScoreUnverified = -6;
constexpr double kLeastDenseMargin = -3, kMostDenseMargin = 12, kClearDenseMargin = 1;
/// Longest query that a reason asks for, over the length of the query at hand.
constexpr double kLongest = 3;

/// (s1 - s2) ln(s1 / s2) with the noise of wrong scores, which grows with the root of the number of
/// windows.
double likelihoodMarginOver(double second_best, const Evidence& e) {
  const double noise = kNoise_nats * std::sqrt(std::max(1, e.windows));
  const double best = e.score + noise, next = std::max(0.0, second_best) + noise;
  if (!(best > next)) return 0;
  return (best - next) * std::log(best / next) / std::sqrt(std::max(1, e.windows));
}

double scoreRatioOf(const PartEvidence& part) {
  return (part.score + kPartPrior_nats) / (std::max(0.0, part.expected) + kPartPrior_nats);
}

/// Score over that of a true pose, the smaller one of the whole query and of its obstacles: a
/// street that repeats fits with its road but not with its houses.
double scoreRatioOf(const PlaceEvidence& e) {
  if (!(e.expected > 0)) return 1;  // nobody knows what a true pose scores: walks
  return std::clamp(std::min(e.score / e.expected, scoreRatioOf(e.obstacles)), kLeast, 1.0);
}

/// Binomial log-likelihood ratio of the number of kept correspondences, true place against wrong.
double correspondenceOdds(const Evidence& e) {
  if (e.with_candidates == 0) return 0;
  const double n = e.with_candidates, k = std::min<double>(e.kept, n);
  const double if_wrong = std::clamp(e.kept_under_null / n, 0.01, 0.99);
  const double if_true = std::clamp(e.kept_if_true, 0.01, 0.99);
  return k * std::log(if_true / if_wrong) + (n - k) * std::log((1 - if_true) / (1 - if_wrong));
}

/// Halves of a query show 0.5 to 1 of one another; where they show less they hardly overlap (a few
/// frames of a camera), which says nothing about how well a right place would fit.
double ratioToSelfConsistency(double above_null, double self_consistency) {
  constexpr double kLeastSelfConsistency = 0.5;
  return above_null / std::max(kLeastSelfConsistency, self_consistency);
}

/// Usual ratio of the inlier ratio above null to the self-consistency: 0.6 to 1 at right places,
/// 0.5 to 0.7 at wrong ones in buildings of similar rooms.
constexpr double kUsualSelfConsistencyRatio = 0.75;
/// Ratio to the self-consistency less the usual one, at most 0; 0 if the map overlap is known.
double selfConsistencyTerm(const DenseEvidence& dense) {
  const bool is_known = dense.of == DenseEvidence::Of::points && dense.converged &&
                        dense.self_consistency && !dense.map_overlap;
  if (!is_known) return 0;
  const double ratio =
      ratioToSelfConsistency(dense.inlier_ratio - dense.null_inlier_ratio, *dense.self_consistency);
  return std::min(0.0, ratio - kUsualSelfConsistencyRatio);
}
/// Positive where less of the query is in conflict with the map than at even odds.
double conflictTerm(const DenseEvidence& dense) {
  constexpr double kWeightOfConflict = 0.5;
  return kWeightOfConflict *
         (kConflictThreshold - dense.conflict_ratio.value_or(kConflictThreshold));
}

/// Inlier ratio above null over its threshold, in the measure that is set at the best place.
double aboveNullOf(double above_null, const std::optional<double>& map_overlap,
                   const std::optional<double>& self_consistency) {
  if (map_overlap) return above_null - kInlierRatioThreshold;
  return ratioToSelfConsistency(above_null, self_consistency.value_or(kUsualSelfConsistency)) -
         kSelfConsistencyThreshold;
}

/// True if the inlier ratio above null is at least that of even odds.
bool fitsClosely(const DenseEvidence& dense) {
  return !dense.converged || aboveNullOf(dense.inlier_ratio - dense.null_inlier_ratio,
                                         dense.map_overlap, dense.self_consistency) >= 0;
}

/// Free-space violation that is equally frequent at right and at wrong places.
constexpr double kViolationThreshold = 0.1, kViolationNoise = 0.03;
/// Values between those of right and of wrong places, for answers that lack the measurement. From
/// the air roofs and crowns cover what the map shows.
constexpr double kUsualMapOverlapFromTheAir = 0.1, kUsualViolation = 0.18;
double freeSpaceTerm(double free_space_violation, double even = kViolationThreshold) {
  return -std::log((free_space_violation + kViolationNoise) / even);
}

/// Whether the inlier ratio of the best place is one of those of the map's wrong places, in [0, 1].
/// In maps of places that are alike half of the right answers lie 6 standard deviations above them,
/// and 1 % of the wrong ones.
double likenessToWrongPlaces(double above_null, const Statistics& s) {
  constexpr double kLike = 3.5, kUnlike = 6, kLeastSpread = 0.05;
  const double off =
      (above_null - s.wrong_place_above_null) / std::max(kLeastSpread, s.wrong_place_spread);
  return std::clamp((kUnlike - off) / (kUnlike - kLike), 0.0, 1.0);
}

/// Part of a dense score that is due to the score of the place.
double logScoreTerm(double score) {
  return kDenseScorePerLogScore * std::log(std::max(1.0, score));
}

/// Margin of the dense score over any other place. A place of about the same score that was not
/// verified may fit as well but for its score.
double denseMarginOf(const Evidence& e) {
  const double fit = denseScore(e, e.dense), best_unverified = logScoreTerm(e.best_unverified);
  double margin = fit - (kDenseScoreUnverified + best_unverified);
  if (e.best_unverified >= kAboutAsWell * e.score)
    margin = std::min(margin, logScoreTerm(e.score) - best_unverified);
  for (const PlaceEvidence& other : e.alternatives)
    margin = std::min(margin, fit - denseScore(other, e.dense));
  return std::max(kLeastDenseMargin, margin);
}

/// Local features ask neither classes nor gravity: a pose that they say far more clearly than any
/// other is likelier right, one of several is likelier wrong. It is bounded: corridors repeat, and
/// rooms of one mould have corners alike.
double oddsOfFeatures(const Statistics& s) {
  constexpr double kMost = 1.5, kEvenMargin = 2;
  if (!s.feature_margin) return 0;
  return kMost * std::clamp(std::log2(*s.feature_margin / kEvenMargin), -1.0, 1.0);
}

double oddsOf(const Statistics& s, const VerdictModel& model) {
  return model.weightsFor(s).logOdds(termsOf(s)) + oddsOfFeatures(s) -
         std::log(s.storeys.value_or(1));  // each may have a wrong place that looks right
}

/// The statistics without dense evidence, as if nothing had been registered.
Statistics ofPlaceAlone(Statistics s) {
  s.dense.of = DenseEvidence::Of::nothing;
  return s;
}

/// Mean over the map's wrong places, shrunk towards the usual value by kUsualPlaces observations.
/// `value`: of a place; nothing if it was not measured.
template <class Value>
double meanOf(const std::vector<WrongPlace>& wrong_places, const Value& value, double usual) {
  constexpr double kUsualPlaces = 4;
  double sum = kUsualPlaces * usual, count = kUsualPlaces;
  for (const WrongPlace& place : wrong_places) {
    const std::optional<double> here = value(place);
    sum += here.value_or(0);
    count += here.has_value();
  }
  return sum / count;
}

void measureWrongPlaces(const std::vector<WrongPlace>& wrong_places, Statistics& s) {
  s.wrong_place_above_null = meanOf(
      wrong_places, [](const WrongPlace& p) { return p.above_null; }, kUsualWrongPlaceAboveNull);
  const auto squaredOff = [&](const WrongPlace& p) -> std::optional<double> {
    if (!p.above_null) return std::nullopt;
    return std::pow(*p.above_null - s.wrong_place_above_null, 2);
  };
  s.wrong_place_spread =
      std::sqrt(meanOf(wrong_places, squaredOff, kUsualWrongPlaceSpread * kUsualWrongPlaceSpread));
  s.wrong_place_miss_ratio = meanOf(
      wrong_places, [](const WrongPlace& p) { return p.miss_ratio; }, kUsualWrongPlaceMissRatio);
}

/// Probability that a pose at the right place is within kNear_m of the truth.
double chanceToBeNear(const Statistics& s) {
  constexpr double kNear_m = 3;
  return s.sigma_m > 0 ? std::erf(kNear_m / (std::sqrt(2) * s.sigma_m)) : 1;
}

/// Odds of the second-best place against the best one, a function of the margin of their dense
/// scores: the frequency at which the second-best was right (offices, halls and towns).
double oddsOfSecondBest(const Statistics& s) {
  constexpr double kPerMargin = 1.5;
  return s.dense.registered() ? std::exp(-kPerMargin * std::min(s.dense_margin, kMostDenseMargin))
                              : 0;
}

/// Medians of terms over right answers, to which a reason compares.
constexpr std::array<double, kTerms> kOfRightAnswers{1, 3.9, 1.4, 0.1, -0.1, 0, 0};

const std::string kUnconverged =
    "the best place does not hold: the registration does not converge there";

/// The words of a verdict.
class Reason {
 public:
  Reason(const Evidence& e, const Statistics& s, const VerdictModel& model, double odds_needed)
      : e_(e), s_(s), model_(model), odds_needed_(odds_needed) {}

  std::string ofAccepted() const {
    std::string text = timesBetter() > 20 ? "no other place fits" : howMuchBetter();
    if (s_.dense.converged && s_.dense.of == DenseEvidence::Of::points)
      text += fmt::format("; inlier ratio of obstacles {:.0f} % ({:.0f} % some metres off)",
                          100 * s_.dense.inlier_ratio, 100 * s_.dense.null_inlier_ratio);
    return text;
  }
  std::string ofAmbiguous() const {
    const std::string apart = e_.second_best_distance_m > 0
                                  ? fmt::format(", {:.0f} m apart", e_.second_best_distance_m)
                                  : "";
    return fmt::format("two places fit about equally well{}{}", apart, whatWouldHelp());
  }
  std::string ofUnconverged() const { return kUnconverged + whatWouldHelp(); }
  std::pair<ReasonCode, std::string> ofRejected() const {
    const auto [code, text] = whyRejected();
    return {code, text + whatWouldHelp()};
  }

 private:
  std::pair<ReasonCode, std::string> whyRejected() const {
    if (oddsOf(s_, model_) >= odds_needed_) {
      const bool is_open = chanceToBeNear(s_) < 1 / (1 + std::exp(-odds_needed_));
      return is_open ? std::pair(ReasonCode::not_converged,
                                 "the place fits, but the position there is open by metres"s)
                     : std::pair(ReasonCode::too_short,
                                 "no place stands out: another one fits nearly as closely"s);
    }
    if (s_.dense.registered() && !s_.dense.converged)
      return {ReasonCode::not_converged, kUnconverged};
    if (!s_.dense.registered()) return {ReasonCode::too_short, ofMargin()};
    switch (decidingTerm()) {
      case kInlierRatio:
        return {ReasonCode::contradicted, ofInlierRatio()};
      case kOverlap:
        if (selfConsistencyTerm(s_.dense) < std::min(0.0, conflictTerm(s_.dense)))
          return {ReasonCode::contradicted,
                  ofInlierRatio() + fmt::format(", and {:.0f} % between halves of the query",
                                                100 * *s_.dense.self_consistency)};
        return {ReasonCode::contradicted,
                fmt::format("the best place does not hold: the {} does not show obstacles that the "
                            "{} has there",
                            showsLess() ? "query" : "map", showsLess() ? "map" : "query")};
      case kFreeSpace:
        return {ReasonCode::contradicted,
                "the best place does not hold: the query saw through what stands there in the map"};
      case kMapCoverage:
        return {ReasonCode::out_of_map,
                fmt::format("the best place does not hold: only {:.0f} % of the query lies where "
                            "the map was seen, where out-of-map queries fit as well",
                            100 * s_.map_coverage)};
      default:
        return {ReasonCode::too_short, ofMargin()};
    }
  }

  std::string ofInlierRatio() const {
    return fmt::format(
        "the best place does not hold: the inlier ratio of obstacles is only "
        "{:.0f} % ({:.0f} % some metres off)",
        100 * s_.dense.inlier_ratio, 100 * s_.dense.null_inlier_ratio);
  }

  std::string ofMargin() const {
    const bool stands_out =
        s_.dense.registered() ? s_.dense_margin >= kClearDenseMargin : s_.likelihood_margin > 0;
    if (!stands_out) return "no place stands out: another one fits as well";
    return fmt::format(
        "no place stands out: the best only {}; of such answers {:.2g} % are wrong, {:.2g} % "
        "at most are accepted",
        howMuchBetter(), 100 * (1 - confidenceOf(s_, model_)), 100 / (1 + std::exp(odds_needed_)));
  }

  /// The term that costs most log odds against the median of right answers.
  Term decidingTerm() const {
    const std::array<double, kTerms> terms = termsOf(s_);
    const EvidenceWeights& weights = model_.weightsFor(s_);
    Term deciding = kMargin;
    double most = -INFINITY;
    for (const Term t : {kMargin, kInlierRatio, kOverlap, kMapCoverage, kFreeSpace}) {
      const double below = weights[t] * (kOfRightAnswers[t] - terms[t]);
      if (below <= most) continue;
      most = below;
      deciding = t;
    }
    return deciding;
  }

  /// The query shows less of the map than the map shows of the query.
  bool showsLess() const {
    const DenseEvidence& dense = s_.dense;
    return dense.miss_ratio.value_or(0) >= dense.conflict_ratio.value_or(0);
  }

  double timesBetter() const { return e_.score / std::max(1.0, e_.runner_up); }

  /// Places of similar bird's-eye view are told apart by their points.
  std::string howMuchBetter() const {
    constexpr double kAlike = 1.15;
    return timesBetter() < kAlike
               ? "fits better than another place that looks like it from above"
               : fmt::format("fits {:.1f} times better than any other place", timesBetter());
  }

  /// The likelihood-ratio margin grows with the length of a query.
  std::string whatWouldHelp() const {
    if (e_.travel_m <= 0 || s_.likelihood_margin <= 0) return "";
    const double missing = odds_needed_ - oddsOf(s_, model_);
    const double per_log_margin = model_.bare[kMargin];
    const double times = std::exp(missing / std::max(0.1, per_log_margin)) - 1;
    if (!(times > 0) || times > kLongest) return "";
    return fmt::format("; about {:.0f} m more would tell", std::max(1.0, times * e_.travel_m));
  }

  const Evidence& e_;
  const Statistics& s_;
  const VerdictModel& model_;
  const double odds_needed_;
};

/// True if the best place would be accepted without the second-best one or, if it fits as a true
/// place does, without any other.
bool oneOfSeveral(Evidence e, const Statistics& judged, const VerdictOptions& o,
                  const VerdictModel& model) {
  if (!e.secondBestIsClose()) return false;
  const bool fits = judged.score_ratio >= kLikeTrue && fitsClosely(judged.dense);
  e.runner_up = e.best_unverified = fits ? 0 : e.third;
  e.alternatives.clear();
  Statistics s = statisticsOf(e);
  s.wrong_place_above_null = judged.wrong_place_above_null;
  s.wrong_place_spread = judged.wrong_place_spread;
  return confidenceOf(s, model) >= o.min_confidence;
}

/// If a little more risk would accept the answer: that risk, as a round number; else empty.
std::string byAHair(double p_wrong, double risk) {
  constexpr double kTimesMore = 10, kMost = 0.1;
  if (p_wrong > std::min(kTimesMore * risk, kMost)) return "";
  double round = std::pow(10, std::floor(std::log10(p_wrong)));
  for (const double factor : {2.0, 2.5, 2.0}) {  // 1, 2, 5, 10
    if (round < p_wrong) round *= factor;
  }
  return fmt::format("; accepted at a risk of {:.2g}", round);
}

}  // namespace

double denseScore(const PlaceEvidence& place, const DenseEvidence& best) {
  const DenseEvidence& dense = place.dense;
  double fit = logScoreTerm(place.score);
  if (best.map_overlap) fit += kDenseScorePerMapOverlap * dense.map_overlap.value_or(0);
  if (!dense.converged) return fit + kDenseScoreUnconverged;
  if (dense.free_space_violation)
    fit += kDenseScorePerFreeSpace * freeSpaceTerm(*dense.free_space_violation);
  const double per_above_null =
      dense.of == DenseEvidence::Of::views ? kDenseScorePerAboveNullOfBev : kDenseScorePerAboveNull;
  return fit + per_above_null * aboveNullOf(dense.inlier_ratio - dense.null_inlier_ratio,
                                            best.map_overlap, best.self_consistency);
}

Statistics statisticsOf(const Evidence& e) {
  Statistics s;
  s.of_surfaces = e.of_surfaces;
  s.likelihood_margin = likelihoodMarginOver(e.runner_up, e);
  s.score_ratio = scoreRatioOf(e);
  if (e.vertices > 0)
    s.vertex_inlier_ratio = std::clamp(e.paired / static_cast<double>(e.vertices), kLeast, 1.0);
  s.map_coverage = std::clamp(e.map_coverage, kLeast, 1.0);
  s.dense = e.dense;
  s.sigma_m = e.sigma_m;
  s.feature_margin = e.feature_margin;
  s.storeys = e.storeys;
  s.other_storey = e.other_storey;
  if (s.dense.registered()) s.dense_margin = denseMarginOf(e);
  return s;
}

double EvidenceWeights::logOdds(const std::array<double, kTerms>& terms) const {
  return std::inner_product(terms.begin(), terms.end(), of.begin(), 0.0);
}

std::array<double, kTerms> termsOf(const Statistics& s) {
  // A street has hundreds of nats in views, so theirs weigh less than those of vertices.
  constexpr double kWeightOfLikelihood = 0.2, kWeightOfViews = 0.5;
  constexpr double kInlierNoise = 0.03, kPointsPerSample = 2.5;
  std::array<double, kTerms> terms{};
  terms[kConstant] = 1;
  const double log_likelihood_margin = std::log(s.likelihood_margin + kNoise_nats);
  const DenseEvidence& dense = s.dense;
  if (!dense.registered()) {
    terms[kMargin] = s.of_surfaces
                         ? kWeightOfViews * (log_likelihood_margin + std::log(s.score_ratio))
                         : log_likelihood_margin + std::log(s.vertex_inlier_ratio);
    return terms;
  }
  terms[kMargin] = std::log(std::min(s.dense_margin, kMostDenseMargin) - kLeastDenseMargin + 1) +
                   kWeightOfLikelihood * log_likelihood_margin;
  // Samples of views lie less far above null at right places than points do.
  const double above_null = (dense.of == DenseEvidence::Of::views ? kPointsPerSample : 1) *
                            (dense.converged ? dense.inlier_ratio - dense.null_inlier_ratio : 0);
  terms[kInlierRatio] = std::log((std::max(0.0, above_null) + kInlierNoise) /
                                 (std::max(0.0, s.wrong_place_above_null) + kInlierNoise));
  if (dense.map_overlap)
    terms[kOverlap] =
        *dense.map_overlap - (dense.aerial ? kUsualMapOverlapFromTheAir : kUsualMapOverlap);
  terms[kOverlap] += selfConsistencyTerm(dense) + conflictTerm(dense);
  terms[kMapCoverage] = std::log(s.map_coverage);
  if (dense.converged && dense.free_space_violation)
    terms[kFreeSpace] = freeSpaceTerm(*dense.free_space_violation, kUsualViolation);
  terms[kWrongPlaceAboveNull] = s.wrong_place_above_null - kUsualWrongPlaceAboveNull;
  if (terms[kWrongPlaceAboveNull] > 0)
    terms[kWrongPlaceAboveNull] *= likenessToWrongPlaces(above_null, s);
  return terms;
}

double confidenceOf(const Statistics& s, const VerdictModel& model) {
  const double confidence =
      chanceToBeNear(s) / (1 + std::exp(-oddsOf(s, model)) + oddsOfSecondBest(s));
  return s.dense.registered() || s.likelihood_margin > 0
             ? confidence
             : std::min(confidence, 0.5);  // one of two at best
}

Verdict judge(const Evidence& e, const VerdictOptions& o, const VerdictModel& model,
              const std::vector<WrongPlace>& wrong_places) {
  Verdict verdict;
  if (!std::isfinite(e.score) || e.score <= 0) {
    verdict.reason = "nothing in the map agrees with the query";
    return verdict;
  }
  Statistics s = statisticsOf(e);
  measureWrongPlaces(wrong_places, s);
  verdict.statistics = s;
  verdict.witnesses.place = oddsOf(ofPlaceAlone(s), model);
  verdict.witnesses.dense = oddsOf(s, model) - verdict.witnesses.place;
  verdict.witnesses.correspondences = correspondenceOdds(e);
  verdict.confidence = confidenceOf(s, model);
  if (e.map_coverage < o.min_known_share) {
    verdict.confidence *= 0.5 * e.map_coverage / o.min_known_share;
    verdict.reason = fmt::format(
        "the best place found is at the rim: only {:.0f} % of the query lies where the "
        "map was seen ({:.0f} % needed)",
        100 * e.map_coverage, 100 * o.min_known_share);
    return verdict;
  }
  const Reason reason(e, s, model, std::log(o.min_confidence / (1 - o.min_confidence)));
  // Points that nobody could lay on those of the map do not say where the query is.
  const bool lies_open = s.dense.of == DenseEvidence::Of::points && !s.dense.converged;
  if (lies_open && verdict.confidence >= o.min_confidence) {
    verdict.confidence = std::nextafter(o.min_confidence, 0.0);
    verdict.reason_code = ReasonCode::not_converged;
    verdict.reason = reason.ofUnconverged();
    return verdict;
  }
  // Floors of one mould have their walls in common, and furniture moves.
  constexpr double kOfOneMould = 0.5;
  if (verdict.confidence >= o.min_confidence && s.other_storey.value_or(0) >= kOfOneMould) {
    verdict.confidence = std::nextafter(o.min_confidence, 0.0);
    verdict.status = Status::ambiguous;
    verdict.reason_code = ReasonCode::ambiguous;
    verdict.reason = fmt::format("another floor counts {:.0f} % of this one, {:.0f} % at most",
                                 100 * *s.other_storey, 100 * kOfOneMould);
    return verdict;
  }
  if (verdict.confidence >= o.min_confidence) {
    verdict.status = Status::accepted;
    verdict.reason_code = ReasonCode::accepted;
    verdict.reason = reason.ofAccepted();
    return verdict;
  }
  if (oneOfSeveral(e, s, o, model)) {
    verdict.status = Status::ambiguous;
    verdict.reason_code = ReasonCode::ambiguous;
    verdict.reason = reason.ofAmbiguous();
  } else {
    std::tie(verdict.reason_code, verdict.reason) = reason.ofRejected();
    if (!lies_open) verdict.reason += byAHair(1 - verdict.confidence, 1 - o.min_confidence);
  }
  return verdict;
}

double horizontalSigma(const Matrix6d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(covariance.topLeftCorner<2, 2>(),
                                                            Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, axes.eigenvalues().maxCoeff()));
}

void setVerdict(Verdict verdict, Localization& answer) {
  answer.status = verdict.status;
  answer.confidence = verdict.confidence;
  answer.reason = std::move(verdict.reason);
  answer.reason_code = verdict.reason_code;
  answer.witnesses = verdict.witnesses;
  answer.statistics = verdict.statistics;
}

}  // namespace xview::verdict
