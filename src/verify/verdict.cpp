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
constexpr double kLeastAgreement = 0.02;  ///< what agrees less is all the same
constexpr double kLikeTrue = 0.8;         ///< agreement of a usual true place
constexpr double kLeastLead = 0.3;        ///< of which a factor counts; as the model was fitted
/// Where the query tells what it shows of the map: agreement over chance at about even odds, and
/// how much more counts, as a house built like another is like it to the centimetre.
constexpr double kEvenAgreement = 0.15, kMostAgreement = 0.15;
/// The same of the share that the agreement has of that of the query with itself. A wrong place of
/// rooms that are alike has half of it, the right one three quarters.
constexpr double kEvenShare = 0.4, kMostShare = 0.45;
constexpr double kUsualOfItself = 0.6;  ///< where it could not be measured
/// Chance that a vertex keeps a correspondence at the true place (search, detection of objects).
constexpr double kKeptIfTrue = 0.62;
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

/// Share of the score of a true pose, the smallest of all and of each part. A street that repeats
/// fits with its road but not with its houses, or with one side only.
double agreementOf(const Evidence& e) {
  if (!(e.expected > 0)) return 1;  // nobody knows what a true pose scores: walks
  return std::clamp(std::min({e.score / e.expected, agreementOf(e.standing),
                              agreementOf(e.sides[0]), agreementOf(e.sides[1])}),
                    kLeastAgreement, 1.0);
}

/// Binomial: how much likelier so many kept correspondences are at the true place than by chance.
double correspondenceOdds(const Evidence& e) {
  if (e.with_candidates == 0) return 0;
  const double n = e.with_candidates, k = std::min<double>(e.kept, n);
  const double by_chance = std::clamp(e.kept_by_chance / n, 0.01, 0.99);
  return k * std::log(kKeptIfTrue / by_chance) +
         (n - k) * std::log((1 - kKeptIfTrue) / (1 - by_chance));
}

/// How much closer than by chance upright things lie on their like, above even odds: as measured,
/// or as a share of what a true place could show.
double excessOf(const Statistics& s, double over_chance) {
  constexpr double kLeastOfItself = 0.1;
  if (s.shown) return over_chance - kEvenAgreement;
  return over_chance / std::max(kLeastOfItself, s.of_itself.value_or(kUsualOfItself)) - kEvenShare;
}
double excessOf(const Statistics& s) { return excessOf(s, s.dense - s.by_chance); }

double logLead(const Statistics& s) { return std::log(s.lead + kLeastLead); }

/// A close rival where as much agrees speaks against the place as much as the place for itself.
double excessOverRival(const Statistics& s) {
  const double excess = excessOf(s);
  if (excess <= 0) return excess;
  return std::min(s.shown ? kMostAgreement : kMostShare,
                  excess - std::max(0.0, excessOf(s, s.rival)));
}

/// Who shows less than a tenth of the map is a stranger, however far the place stands out: it
/// counts twice from there.
double shownTerm(const Statistics& s) {
  constexpr double kLittle = 0.1;
  return s.shown ? *s.shown + std::min(0.0, *s.shown - kLittle) : 0;
}

/// A tenth is as usual at right places as at wrong ones; nothing is said where it was not asked.
/// Beside what is shown it is asked of exact depths, of which a quarter is, and says less.
double seenLittle(const Statistics& s) {
  constexpr double kNoise = 0.03, kEven = 0.1, kEvenOfExact = 0.25, kMostOfExact = 0.35;
  if (!s.seen_through) return 0;
  const double little = -std::log((*s.seen_through + kNoise) / (s.shown ? kEvenOfExact : kEven));
  return s.shown ? std::min(kMostOfExact, little) : little;
}

/// The part of the odds that the terms [first, last) make.
double oddsOf(const Statistics& s, const VerdictModel& model, std::size_t first,
              std::size_t last = kTerms) {
  const auto terms = termsOf(s), weights = model.weightsFor(s);
  return std::inner_product(terms.begin() + first, terms.begin() + last, weights.begin() + first,
                            0.0);
}

double placeOdds(const Statistics& s, const VerdictModel& model) {
  return oddsOf(s, model, 0, kPlaceTerms);
}

double denseOdds(const Statistics& s, const VerdictModel& model) {
  return oddsOf(s, model, kPlaceTerms);
}

/// Of a rival that nobody asked nothing better is known than that it agrees as well.
double excessAtRival(const Evidence& e) {
  const DenseEvidence& there = e.dense_at_runner_up.value_or(e.dense);
  return there.settled ? there.agreement - there.by_chance : 0;
}

/// How far the query shows the map at the best place, less what it shows of it at the next one, as
/// far as that is close: streets of one town stand alike.
double shownOver(const Evidence& e) {
  const double at_rival =
      e.dense_at_runner_up ? e.dense_at_runner_up->shown.value_or(0) : *e.dense.shown;
  const double close = e.score > 0 ? std::clamp(2 * e.runner_up / e.score - 1, 0.0, 1.0) : 1;
  return *e.dense.shown - close * std::max(0.0, at_rival);
}

/// Share of the map's own stretches that find a place elsewhere which stands out as far and fits as
/// well; what fits less counts less. Those of a usual map find none, which is taken of as many
/// more.
double shareOfLookAlikes(const Statistics& s, const std::vector<LookAlike>& look_alikes) {
  constexpr double kFits = 0.9, kFitsNot = 0.7, kUsual = 25;
  double found = 0;
  for (const LookAlike& l : look_alikes) {
    if (l.lead >= s.lead)
      found += std::clamp((l.share / s.agreement - kFitsNot) / (kFits - kFitsNot), 0.0, 1.0);
  }
  return found / (static_cast<double>(look_alikes.size()) + kUsual);
}

/// How much less likely a copy of the map is for what the query shows: e times for every stretch of
/// the way along which it shows all of the map. A copy shows less of it, the less the longer it is.
double copyLeft(const Statistics& s, double travel_m) {
  constexpr double kShownByCopy = 0.2, kStretch_m = 15;
  return std::exp(-std::max(0.0, s.shown.value_or(0) - kShownByCopy) * travel_m / kStretch_m);
}

/// Chance that the pose is as near to the truth as that its place is the right one.
double chanceToBeNear(const Statistics& s) {
  constexpr double kNear_m = 3;
  return s.sigma_m > 0 ? std::erf(kNear_m / (std::sqrt(2) * s.sigma_m)) : 1;
}

double confidenceOf(double odds, const Statistics& s) {
  return chanceToBeNear(s) / (1 + std::exp(-odds) + s.look_alike);
}

/// The words of a verdict.
class Reason {
 public:
  Reason(const Evidence& e, const Statistics& s, const VerdictModel& model, double odds_needed)
      : e_(e), s_(s), model_(model), odds_needed_(odds_needed) {}

  std::string ofAccepted() const {
    const double times = e_.score / std::max(1.0, e_.runner_up);
    std::string text = times > 20
                           ? "no other place fits"
                           : fmt::format("fits {:.1f} times better than any other place", times);
    if (s_.settled && !s_.views)
      text += fmt::format(
          "; {:.0f} % of what stands upright lies on its like there ({:.0f} % by "
          "chance)",
          100 * s_.dense, 100 * s_.by_chance);
    return text;
  }
  std::string ofAmbiguous() const {
    const std::string apart =
        e_.rival_distance_m > 0 ? fmt::format(", {:.0f} m apart", e_.rival_distance_m) : "";
    return fmt::format("two places fit about equally well{}{}", apart, whatWouldHelp());
  }
  std::string ofRejected() const {
    const double times = e_.score / std::max(1.0, e_.runner_up);
    const double odds = placeOdds(s_, model_) + denseOdds(s_, model_);
    if (odds >= odds_needed_ && chanceToBeNear(s_) < 1 - s_.look_alike)
      return "the place fits, but the position there is open by metres" + whatWouldHelp();
    if (odds >= odds_needed_)
      return fmt::format(
          "the place fits, but so do others in this map: {:.0f} % of its own stretches look as "
          "much like another one{}",
          100 * s_.look_alike, whatWouldHelp());
    if (s_.registered && !s_.settled)
      return "the best place does not hold: the points do not settle on the map there" +
             whatWouldHelp();
    if (oddsOf(s_, model_, kShown) < -1)
      return "the best place does not hold: the query does not show what stands there in the map" +
             whatWouldHelp();
    if (oddsOf(s_, model_, kSeenThrough, kSeenThrough + 1) < -1)
      return "the best place does not hold: the query saw through what stands there in the map" +
             whatWouldHelp();
    if (denseOdds(s_, model_) < -1)
      return fmt::format(
                 "the best place does not hold: only {:.0f} % of what stands upright lies "
                 "on its like there ({:.0f} % by chance)",
                 100 * s_.dense, 100 * s_.by_chance) +
             whatWouldHelp();
    if (s_.lead <= 0) return "no place stands out: another one fits as well" + whatWouldHelp();
    return fmt::format(
        "no place stands out: the best fits only {:.1f} times better than the next{}", times,
        whatWouldHelp());
  }

 private:
  /// Leads grow with the length of a query.
  std::string whatWouldHelp() const {
    if (e_.travel_m <= 0 || s_.lead <= 0) return "";
    const double missing = odds_needed_ - placeOdds(s_, model_) - denseOdds(s_, model_);
    const auto weights = model_.weightsFor(s_);
    const double excess = s_.settled ? std::max(0.0, excessOverRival(s_)) : 0;
    const double weight = weights[kLead] + excess * weights[kLeadThere];
    const double times = std::exp(missing / std::max(0.1, weight)) - 1;
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
bool oneOfSeveral(const Evidence& e, Statistics s, const VerdictOptions& o,
                  const VerdictModel& model) {
  if (!e.rivalIsClose()) return false;
  const bool fits = s.agreement >= kLikeTrue && (!s.registered || excessOf(s) >= 0);
  s.lead = leadOver(fits ? 0 : e.third, e);
  s.rival = 0;
  return confidenceOf(placeOdds(s, model) + denseOdds(s, model), s) >= o.min_confidence;
}

}  // namespace

Statistics statisticsOf(const Evidence& e) {
  Statistics s;
  s.lead = leadOver(e.runner_up, e);
  s.agreement = agreementOf(e);
  s.registered = e.dense.of != DenseEvidence::Of::nothing;
  s.settled = s.registered && e.dense.settled;
  s.views = e.dense.of == DenseEvidence::Of::views;
  if (e.dense.shown) s.shown = shownOver(e);
  s.of_itself = e.dense.of_itself;
  s.seen_through = e.dense.seen_through;
  s.sigma_m = e.sigma_m;
  if (!s.settled) return s;
  s.dense = e.dense.agreement;
  s.by_chance = e.dense.by_chance;
  if (e.rivalIsClose()) s.rival = excessAtRival(e);
  return s;
}

DenseEvidence denseEvidenceOf(const Statistics& s) {
  using Of = DenseEvidence::Of;
  return {!s.registered ? Of::nothing
          : s.views     ? Of::views
                        : Of::points,
          s.settled,
          s.dense,
          s.by_chance,
          s.shown,
          s.of_itself,
          s.seen_through};
}

std::array<double, kTerms> VerdictModel::weightsFor(const Statistics& s) const {
  std::array<double, kTerms> weights{};
  if (!s.registered)
    std::copy(alone.begin(), alone.end(), weights.begin());
  else if (!s.shown)
    std::copy(registered.begin(), registered.end(), weights.begin());
  else
    weights = shown;
  return weights;
}

std::array<double, kTerms> termsOf(const Statistics& s) {
  std::array<double, kTerms> terms{};
  terms[kConstant] = 1;
  terms[kLead] = logLead(s);
  terms[kAgreement] = std::log(s.agreement);
  if (!s.registered) return terms;
  terms[kShown] = shownTerm(s);
  terms[kFailed] = !s.settled;
  terms[kViews] = s.settled && s.views;
  if (!s.settled) return terms;
  terms[kExcess] = excessOverRival(s);
  terms[kLeadThere] = std::max(0.0, terms[kExcess]) * std::max(0.0, terms[kLead]);
  terms[kSeenThrough] = seenLittle(s);
  return terms;
}

double oddsAmongPlaces(const Evidence& e, const VerdictModel& model) {
  Statistics s = statisticsOf(e);
  s.rival = 0;
  const double odds = placeOdds(s, model) + denseOdds(s, model);
  return s.settled ? odds + model.weightsFor(s)[kExcess] * (excessOf(s) - excessOverRival(s))
                   : odds;
}

Verdict judge(const Evidence& e, const VerdictOptions& o, const VerdictModel& model,
              const std::vector<LookAlike>& look_alikes) {
  Verdict verdict;
  if (!std::isfinite(e.score) || e.score <= 0) {
    verdict.reason = "nothing in the map agrees with the query";
    return verdict;
  }
  Statistics s = statisticsOf(e);
  s.look_alike = shareOfLookAlikes(s, look_alikes) * copyLeft(s, e.travel_m);
  verdict.statistics = s;
  verdict.witnesses.place = placeOdds(s, model);
  verdict.witnesses.dense = denseOdds(s, model);
  verdict.witnesses.correspondences = correspondenceOdds(e);
  verdict.confidence = confidenceOf(verdict.witnesses.place + verdict.witnesses.dense, s);
  if (s.lead <= 0) verdict.confidence = std::min(verdict.confidence, 0.5);  // one of two at best
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

}  // namespace xview::verify
