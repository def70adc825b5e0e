// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "xview/types/localization.h"
#include "xview/types/option_field.h"

namespace xview::verify {

struct VerdictOptions {
  /// Share of right ones among answers with just this evidence, from which on an answer is
  /// accepted.
  double min_confidence = 0.99;
  double min_known_share = 0.15;  ///< share of the query that must lie where the map was seen
  std::string model;  ///< file of xview learn --verdict; empty = what the program comes with
};

template <class Visitor>
void visit(VerdictOptions& o, Visitor&& field) {
  field("min_confidence", o.min_confidence, Range{0.5, 0.999999999},
        "confidence from which on an answer is accepted");
  field("min_known_share", o.min_known_share, Range{0, 1},
        "share of the query that must lie where the map was seen");
  field("model", o.model, "file of xview learn --verdict; empty = built in");
}

/// What a part of a query says for a place, and what it would say at a true pose [nats].
struct PartEvidence {
  double score = 0, expected = 0;
};

/// Share of the best score from which on a place may be the right one and is to be looked at
/// closely.
constexpr double kAboutAsWell = 0.75;

/// What speaks for one place by itself.
struct PlaceEvidence {
  double score = 0;         ///< [nats]
  double expected = 0;      ///< score that a true pose would have on average [nats]
  double map_coverage = 1;  ///< share of the query where the map knows anything
  PartEvidence obstacles;   ///< views: what stands upright
  DenseEvidence dense;
};

/// What speaks for and against the best place of one query, or of several together, by whatever
/// method and field it was found.
struct Evidence : PlaceEvidence {
  double runner_up = 0;  ///< score of the best other place; what unseen area scores (0) if none
  double third = 0;      ///< score of the place after that
  std::vector<PlaceEvidence> alternatives;  ///< other places that were looked at closely
  double best_unverified = 0;               ///< score of the best place that was not
  int windows = 1;  ///< queries that share no frame, whose evidence is summed here
  double second_best_distance_m = 0;  ///< from the best place to the runner-up; 0 = not known
  double travel_m = 0;                ///< of the query; 0 = it stood

  int vertices = 0;            ///< of the query, as the walks see it
  int kept = 0;                ///< correspondences that survive sample consensus at the best place
  int with_candidates = 0;     ///< vertices that had a candidate there
  double kept_under_null = 0;  ///< how many of these would keep one at a wrong place
  double kept_if_true = 0;     ///< chance that one of these keeps one at the true place
  double sigma_m = 0;          ///< as in Statistics

  /// The runner-up scores so well that it must be asked whether points agree there as well.
  bool secondBestIsClose() const { return runner_up > 0.5 * score; }
};

/// Without what the map knows of itself.
Statistics statisticsOf(const Evidence& evidence);

/// What log odds of right against wrong are linear in, if every other query is from elsewhere.
enum Term : std::size_t {
  kConstant,
  kScoreRatio,  ///< share of the score of a true pose; its logarithm where nothing was registered
  kLikelihoodMargin,  ///< logarithm of the lead
  kMapCoverage,       ///< logarithm of the share of the query that lies where the map was seen:
                 ///< strangers fit best where they hang over its edge
  kAboveNull,  ///< dense agreement over that by chance, as a share of that of the query with itself
               ///< where that was asked; 0 if the registration did not settle
  kConverged,  ///< 1 if the registration found a pose near the place
  kObstacleOverlap,            ///< how far what stands in the query stands in the map as well
  kMapOverlap,                 ///< how far the query shows what stands in the map
  kMissRatio,                  ///< how little of that it does not show
  kConflictRatio,              ///< how little of what stands in the query the map contradicts
  kFreeSpaceViolation,         ///< logarithm of how little of the map the query saw through
  kDenseMargin,                ///< how much better the place fits than any other
  kDenseMarginTimesAboveNull,  ///< which says more where the points agree: times what is in excess
  kLogDenseMargin,  ///< logarithm of the margin: a stranger may fit one place of the map only, too
  kWrongPlaceAboveNull,  ///< how closely points lie on their like at wrong places of this map, over
                         ///< usual
  kWrongPlaceMissRatio,  ///< how much of the map stretches of it miss at wrong places, over usual
  kTerms
};

/// Log odds x = weights . terms, and x + sharpness * max(0, x - knee)^2 above the knee: where all
/// witnesses agree, right answers are more frequent than a sum of dependent witnesses says.
struct EvidenceWeights {
  std::array<double, kTerms> of{};
  double knee = 0, sharpness = 0;

  double& operator[](Term term) { return of[term]; }
  double operator[](Term term) const { return of[term]; }
  double logOdds(const std::array<double, kTerms>& terms) const;
  /// The x of which these are the log odds.
  double linearPart(double log_odds) const;
};

/// The weights. The witnesses are not independent, so those that there are were fitted together:
/// the place alone, with a registration, with what the query shows of the map as well, and the same
/// of queries from the air. Terms that such evidence has not weigh 0.
struct VerdictModel {
  EvidenceWeights alone, registered, with_overlap, air;

  /// Those for the evidence that there is.
  const EvidenceWeights& weightsFor(const Statistics& statistics) const;
};

/// 0 for evidence that there is not.
std::array<double, kTerms> termsOf(const Statistics& statistics);

/// How well a place fits after a close look, to tell the places of one query apart [nats]: how
/// closely its points lie on their like, however closely, what the query shows there of the map,
/// and how little of it was seen through. To a stranger a copy of the map is as good as the map; of
/// two places the one that fits to the centimetre is it. `best`: what was asked there is compared.
double denseScore(const PlaceEvidence& place, const DenseEvidence& best);

/// The model that the program comes with, config/verdict.txt.
const VerdictModel& defaultVerdictModel();
/// That of the options; throws Error if it cannot be read.
VerdictModel verdictModelOf(const VerdictOptions& options);
/// Throws Error with path and line if the file is not one that toText() made.
VerdictModel readVerdictModel(const std::string& path);
std::string toText(const VerdictModel& model);

/// An answer of which is known whether it is right.
struct JudgedStatistics {
  Statistics statistics;
  bool right = false;
  std::size_t group = 0;  ///< answers of one world or recording
};
/// The likeliest model if all right answers weigh as much as all wrong ones: logistic regression
/// with a small ridge, in which no better witness may count against an answer. Its odds are then
/// calibrated on answers that did not set the weights: each group is judged by the others. Each set
/// of weights is learned from all answers that have its evidence; where none has, the weights stay
/// those of the program. Throws Error if right or wrong ones are missing.
VerdictModel fitVerdictModel(const std::vector<JudgedStatistics>& answers);

struct Verdict {
  Status status = Status::rejected;
  double confidence = 0;
  std::string reason;
  Witnesses witnesses;
  Statistics statistics;
};

/// One formula and one scale for views, bare graphs, walks and sequences.
///
/// Without a registration the place must stand out by its score: the odds grow with the logarithm
/// of the lead (s1 - s2) ln(s1 / s2), as 60 nats before the next place are much over 30 and little
/// over 600. With one it must stand out by how it fits after close looks at the best few places
/// (denseScore), lie where the map was seen, and by itself fit closely or, where that can be asked,
/// stand as the map does and show what the map shows. Correspondences add nothing to these
/// (measured) and are reported only.
///
/// How unlikely evidence is at a wrong place depends on the map: streets of one plan and rooms of
/// one floor fit each other closely. `wrong_places` samples that in the map at hand (none if nobody
/// asked it: a usual map). And a pose is right only as far as its own covariance leaves it near the
/// truth.
Verdict judge(const Evidence& evidence, const VerdictOptions& options,
              const VerdictModel& model = defaultVerdictModel(),
              const std::vector<WrongPlace>& wrong_places = {});

/// Of the position of a pose in the plane, where it is known least [m].
double horizontalSigma(const Matrix6d& covariance);

/// Makes it that of an answer.
void setVerdict(Verdict verdict, Localization& answer);
/// Takes an acceptance back: the answer is rejected, and likelier wrong than right.
void refuse(std::string reason, Localization& answer);

}  // namespace xview::verify
