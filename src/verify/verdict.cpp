// SPDX-License-Identifier: BSD-3-Clause
#include "xview/verify/verdict.h"

#include <fmt/core.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace xview::verify {
namespace {

/// What a wrong place may score by chance, so that small scores say little [nats].
constexpr double kNoise_nats = 2;
/// Added to scores of parts, of which a small one says little [nats].
constexpr double kPartPrior_nats = 15;
constexpr double kLeast = 0.02;     ///< shares of less are all the same
constexpr double kLikeTrue = 0.8;   ///< agreement of a usual true place
constexpr double kLeastLead = 0.3;  ///< of which a factor counts; as the model was fitted
/// Agreement over chance at about even odds: as measured where the query tells what it shows of the
/// map, else as a share of that of the query with itself. A wrong place of rooms that are alike has
/// half of it, the right one three quarters.
constexpr double kEvenAgreement = 0.15, kEvenShare = 0.4;
constexpr double kUsualOfItself = 0.6;  ///< where it could not be measured
/// What tells the places of one query apart: their points, what is shown there of the map, how
/// little was seen through, and their scores; and what a place fits that nobody looked at closely.
/// Views from above lie half as far over chance at right places as points do.
constexpr double kFitPerExcess = 14, kFitPerExcessOfViews = 20, kFitPerShown = 7,
                 kFitPerSeenThrough = 2, kFitPerLogScore = 2, kFitUnsettled = -4,
                 kFitPassedOver = -6;
constexpr double kLeastMargin = -3, kMostMargin = 12, kClearMargin = 1;
/// More than this many times its length is not asked of a query.
constexpr double kLongest = 3;

/// (s1 - s2) ln(s1 / s2) with the noise of wrong scores, which grows with the root of the number of
/// windows.
double leadOver(double rival, const Evidence& e) {
  const double noise = kNoise_nats * std::sqrt(std::max(1, e.windows));
  const double best = e.score + noise, next = std::max(0.0, rival) + noise;
  if (!(best > next)) return 0;
  return (best - next) * std::log(best / next) / std::sqrt(std::max(1, e.windows));
}

double agreementOf(const PartEvidence& part) {
  return (part.score + kPartPrior_nats) / (std::max(0.0, part.expected) + kPartPrior_nats);
}

/// Share of the score of a true pose, the smaller one of all and of what stands upright: a street
/// that repeats fits with its road but not with its houses.
double agreementOf(const PlaceEvidence& e) {
  if (!(e.expected > 0)) return 1;  // nobody knows what a true pose scores: walks
  return std::clamp(std::min(e.score / e.expected, agreementOf(e.standing)), kLeast, 1.0);
}

/// Binomial: how much likelier so many kept correspondences are at the true place than by chance.
double correspondenceOdds(const Evidence& e) {
  if (e.with_candidates == 0) return 0;
  const double n = e.with_candidates, k = std::min<double>(e.kept, n);
  const double by_chance = std::clamp(e.kept_by_chance / n, 0.01, 0.99);
  const double if_true = std::clamp(e.kept_if_true, 0.01, 0.99);
  return k * std::log(if_true / by_chance) + (n - k) * std::log((1 - if_true) / (1 - by_chance));
}

/// Of how closely a query lies on itself.
double shareOfItself(double over_chance, double of_itself) {
  constexpr double kLeastOfItself = 0.1;
  return over_chance / std::max(kLeastOfItself, of_itself);
}

/// How much closer than by chance upright things lie on their like, above even odds, as it is
/// measured at the best place.
double excessOf(double over_chance, const std::optional<double>& shown,
                const std::optional<double>& of_itself) {
  if (shown) return over_chance - kEvenAgreement;
  return shareOfItself(over_chance, of_itself.value_or(kUsualOfItself)) - kEvenShare;
}

/// 0 if the registration did not settle.
double excessOf(const Statistics& s) {
  const DenseEvidence& dense = s.dense;
  return dense.settled ? excessOf(dense.agreement - dense.by_chance, dense.shown, dense.of_itself)
                       : 0;
}

/// A tenth is as usual at right places as at wrong ones.
constexpr double kEvenSeen = 0.1;
double seenLittle(double seen_through, double even = kEvenSeen) {
  constexpr double kNoise = 0.03;
  return -std::log((seen_through + kNoise) / even);
}

/// The part of a fit that is the score of the place.
double fitOfScore(double score) { return kFitPerLogScore * std::log(std::max(1.0, score)); }

/// How much better the place fits than any other. One that scores about as well and that nobody
/// looked at closely may fit as well but for its score.
double marginOf(const Evidence& e) {
  const double fit = fitOf(e, e.dense), passed_over = fitOfScore(e.passed_over);
  double margin = fit - (kFitPassedOver + passed_over);
  if (e.passed_over >= kAboutAsWell * e.score)
    margin = std::min(margin, fitOfScore(e.score) - passed_over);
  for (const PlaceEvidence& rival : e.rivals)
    margin = std::min(margin, fit - fitOf(rival, e.dense));
  return std::clamp(margin, kLeastMargin, kMostMargin);
}

double oddsOf(const Statistics& s, const VerdictModel& model) {
  return model.weightsFor(s).logOdds(termsOf(s));
}

double oddsOfTerm(const Statistics& s, const VerdictModel& model, Term term) {
  return termsOf(s)[term] * model.weightsFor(s)[term];
}

/// Of the place by itself, as if nothing had been registered.
double placeOdds(Statistics s, const VerdictModel& model) {
  s.dense.of = DenseEvidence::Of::nothing;
  return oddsOf(s, model);
}

/// Mean over wrong places of a map, drawn to that of a usual map by as many as a few more.
double meanOf(const std::vector<WrongPlace>& wrong_places,
              std::optional<double> WrongPlace::*witness, double usual) {
  constexpr double kUsualPlaces = 4;
  double sum = kUsualPlaces * usual, count = kUsualPlaces;
  for (const WrongPlace& place : wrong_places) {
    sum += (place.*witness).value_or(0);
    count += (place.*witness).has_value();
  }
  return sum / count;
}

/// Chance that the pose is as near to the truth as that its place is the right one.
double chanceToBeNear(const Statistics& s) {
  constexpr double kNear_m = 3;
  return s.sigma_m > 0 ? std::erf(kNear_m / (std::sqrt(2) * s.sigma_m)) : 1;
}

/// Odds against a registered place that the next one makes, as far as that fits as well: as often
/// as the next place was the right one (offices, halls and towns).
double oddsOfNextPlace(const Statistics& s) {
  constexpr double kPerMargin = 1.5;
  return s.dense.registered() ? std::exp(-kPerMargin * s.margin) : 0;
}

double confidenceOf(double odds, const Statistics& s) {
  const double confidence = chanceToBeNear(s) / (1 + std::exp(-odds) + oddsOfNextPlace(s));
  return s.dense.registered() || s.lead > 0 ? confidence
                                            : std::min(confidence, 0.5);  // one of two at best
}

/// The words of a verdict.
class Reason {
 public:
  Reason(const Evidence& e, const Statistics& s, const VerdictModel& model, double odds_needed)
      : e_(e), s_(s), model_(model), odds_needed_(odds_needed) {}

  std::string ofAccepted() const {
    std::string text = timesBetter() > 20 ? "no other place fits" : howMuchBetter();
    if (s_.dense.settled && s_.dense.of == DenseEvidence::Of::points)
      text += fmt::format(
          "; {:.0f} % of what stands upright lies on its like there ({:.0f} % by "
          "chance)",
          100 * s_.dense.agreement, 100 * s_.dense.by_chance);
    return text;
  }
  std::string ofAmbiguous() const {
    const std::string apart =
        e_.rival_distance_m > 0 ? fmt::format(", {:.0f} m apart", e_.rival_distance_m) : "";
    return fmt::format("two places fit about equally well{}{}", apart, whatWouldHelp());
  }
  std::string ofRejected() const {
    const double odds = oddsOf(s_, model_);
    if (odds >= odds_needed_)
      return "the place fits, but the position there is open by metres" + whatWouldHelp();
    if (s_.dense.registered() && !s_.dense.settled)
      return "the best place does not hold: the points do not settle on the map there" +
             whatWouldHelp();
    const double in_query = worseOf(kShown, kMissing), in_map = worseOf(kStanding, kContradicted);
    if (std::min(in_query, in_map) < -1) {
      const bool of_query = in_query < in_map;
      return fmt::format(
                 "the best place does not hold: the {} does not show what stands there in the {}",
                 of_query ? "query" : "map", of_query ? "map" : "query") +
             whatWouldHelp();
    }
    if (oddsOfTerm(s_, model_, kSeenThrough) < -1)
      return "the best place does not hold: the query saw through what stands there in the map" +
             whatWouldHelp();
    if (excessOf(s_) < 0)
      return fmt::format(
                 "the best place does not hold: only {:.0f} % of what stands upright lies "
                 "on its like there ({:.0f} % by chance)",
                 100 * s_.dense.agreement, 100 * s_.dense.by_chance) +
             whatWouldHelp();
    if (s_.dense.registered() ? s_.margin < kClearMargin : s_.lead <= 0)
      return "no place stands out: another one fits as well" + whatWouldHelp();
    if (oddsOfTerm(s_, model_, kKnown) < -2)
      return fmt::format(
                 "the best place does not hold: only {:.0f} % of the query lies where the map was "
                 "seen, where strangers fit as well",
                 100 * s_.known) +
             whatWouldHelp();
    return "no place stands out: the best only " + howMuchBetter() + whatWouldHelp();
  }

 private:
  double timesBetter() const { return e_.score / std::max(1.0, e_.runner_up); }

  double worseOf(Term a, Term b) const {
    return std::min(oddsOfTerm(s_, model_, a), oddsOfTerm(s_, model_, b));
  }

  /// Places that look alike from above are told apart by their points.
  std::string howMuchBetter() const {
    constexpr double kAlike = 1.15;
    return timesBetter() < kAlike
               ? "fits better than another place that looks like it from above"
               : fmt::format("fits {:.1f} times better than any other place", timesBetter());
  }

  /// Leads grow with the length of a query.
  std::string whatWouldHelp() const {
    if (e_.travel_m <= 0 || s_.lead <= 0) return "";
    const EvidenceWeights& weights = model_.weightsFor(s_);
    const double missing =
        weights.linearPart(odds_needed_) - weights.linearPart(oddsOf(s_, model_));
    const double times = std::exp(missing / std::max(0.1, model_.alone[kLead])) - 1;
    if (!(times > 0) || times > kLongest) return "";
    return fmt::format("; about {:.0f} m more would tell", std::max(1.0, times * e_.travel_m));
  }

  const Evidence& e_;
  const Statistics& s_;
  const VerdictModel& model_;
  const double odds_needed_;
};

/// The best place would be believed if its rival were not there, or if none of several were that
/// fit as a true place would.
bool oneOfSeveral(Evidence e, const Statistics& judged, const VerdictOptions& o,
                  const VerdictModel& model) {
  if (!e.rivalIsClose()) return false;
  const bool fits = judged.agreement >= kLikeTrue && excessOf(judged) >= 0;
  e.runner_up = e.passed_over = fits ? 0 : e.third;
  e.rivals.clear();
  Statistics s = statisticsOf(e);
  s.null_excess = judged.null_excess;
  s.null_missing = judged.null_missing;
  return confidenceOf(oddsOf(s, model), s) >= o.min_confidence;
}

}  // namespace

double fitOf(const PlaceEvidence& place, const DenseEvidence& best) {
  const DenseEvidence& dense = place.dense;
  double fit = fitOfScore(place.score);
  if (best.shown) fit += kFitPerShown * dense.shown.value_or(0);
  if (!dense.settled) return fit + kFitUnsettled;
  if (dense.seen_through) fit += kFitPerSeenThrough * seenLittle(*dense.seen_through);
  const double per_excess =
      dense.of == DenseEvidence::Of::views ? kFitPerExcessOfViews : kFitPerExcess;
  return fit + per_excess * excessOf(dense.agreement - dense.by_chance, best.shown, best.of_itself);
}

Statistics statisticsOf(const Evidence& e) {
  Statistics s;
  s.lead = leadOver(e.runner_up, e);
  s.agreement = agreementOf(e);
  s.known = std::clamp(e.known_share, kLeast, 1.0);
  s.dense = e.dense;
  s.sigma_m = e.sigma_m;
  if (s.dense.registered()) s.margin = marginOf(e);
  return s;
}

double EvidenceWeights::logOdds(const std::array<double, kTerms>& terms) const {
  const double x = std::inner_product(terms.begin(), terms.end(), of.begin(), 0.0);
  return x + sharpness * std::pow(std::max(0.0, x - knee), 2);
}

double EvidenceWeights::linearPart(double log_odds) const {
  const double over = log_odds - knee;
  if (!(over > 0 && sharpness > 0)) return log_odds;
  return knee + (std::sqrt(1 + 4 * sharpness * over) - 1) / (2 * sharpness);
}

const EvidenceWeights& VerdictModel::weightsFor(const Statistics& s) const {
  if (!s.dense.registered()) return alone;
  if (!s.dense.shown) return registered;
  return s.dense.aerial ? air : shown;
}

std::array<double, kTerms> termsOf(const Statistics& s) {
  std::array<double, kTerms> terms{};
  terms[kConstant] = 1;
  if (!s.dense.registered()) {
    terms[kAgreement] = std::log(s.agreement);
    terms[kLead] = std::log(s.lead + kLeastLead);
    return terms;
  }
  terms[kKnown] = std::log(s.known);
  const DenseEvidence& dense = s.dense;
  const bool saw = dense.settled && dense.seen_through;
  if (!dense.shown) {
    terms[kExcess] = excessOf(s);
    terms[kMargin] = s.margin;
    terms[kMarginThere] = std::max(0.0, terms[kExcess]) * std::max(0.0, s.margin);
    if (saw) terms[kSeenThrough] = seenLittle(*dense.seen_through);
    return terms;
  }
  // What a true pose scores is known badly where labels are poor, and from the air; what stands
  // where, and what is contradicted there, is seen.
  terms[kShown] = *dense.shown;
  terms[kContradicted] = kEvenBlocks - dense.contradicted.value_or(kEvenBlocks);
  terms[kLogMargin] = std::log(s.margin - kLeastMargin + 1);
  if (dense.aerial) {
    terms[kExcess] = excessOf(s);
    terms[kNullMissing] = s.null_missing - kUsualNullMissing;
    return terms;
  }
  // There it is asked of exact depths, of which a quarter is even, and says less.
  constexpr double kEvenOfExact = 0.25, kMostOfExact = 0.35;
  constexpr double kEvenStanding = 0.8;
  terms[kSettled] = dense.settled;
  terms[kStanding] = dense.standing.value_or(kEvenStanding) - kEvenStanding;
  terms[kMissing] = kEvenBlocks - dense.missing.value_or(kEvenBlocks);
  terms[kNullExcess] = s.null_excess - kUsualNullExcess;
  if (saw)
    terms[kSeenThrough] = std::min(kMostOfExact, seenLittle(*dense.seen_through, kEvenOfExact));
  return terms;
}

Verdict judge(const Evidence& e, const VerdictOptions& o, const VerdictModel& model,
              const std::vector<WrongPlace>& wrong_places) {
  Verdict verdict;
  if (!std::isfinite(e.score) || e.score <= 0) {
    verdict.reason = "nothing in the map agrees with the query";
    return verdict;
  }
  Statistics s = statisticsOf(e);
  s.null_excess = meanOf(wrong_places, &WrongPlace::excess, kUsualNullExcess);
  s.null_missing = meanOf(wrong_places, &WrongPlace::missing, kUsualNullMissing);
  verdict.statistics = s;
  verdict.witnesses.place = placeOdds(s, model);
  verdict.witnesses.dense = oddsOf(s, model) - verdict.witnesses.place;
  verdict.witnesses.correspondences = correspondenceOdds(e);
  verdict.confidence = confidenceOf(oddsOf(s, model), s);
  if (e.known_share < o.min_known_share) {
    verdict.confidence *= 0.5 * e.known_share / o.min_known_share;
    verdict.reason =
        fmt::format("only {:.0f} % of the query lies where the map was seen ({:.0f} % needed)",
                    100 * e.known_share, 100 * o.min_known_share);
    return verdict;
  }
  const Reason reason(e, s, model, std::log(o.min_confidence / (1 - o.min_confidence)));
  if (verdict.confidence >= o.min_confidence) {
    verdict.status = Status::accepted;
    verdict.reason = reason.ofAccepted();
    return verdict;
  }
  if (oneOfSeveral(e, s, o, model)) {
    verdict.status = Status::ambiguous;
    verdict.reason = reason.ofAmbiguous();
  } else {
    verdict.reason = reason.ofRejected();
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
  answer.witnesses = verdict.witnesses;
  answer.statistics = verdict.statistics;
}

void refuse(std::string reason, Localization& answer) {
  constexpr double kLessThanEven = 0.49;
  answer.status = Status::rejected;
  answer.confidence = std::min(answer.confidence, kLessThanEven);
  answer.reason = std::move(reason);
}

}  // namespace xview::verify
