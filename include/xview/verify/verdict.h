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
  /// An answer is accepted if this share of answers with the same evidence is right.
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

/// Log-likelihood ratio of a part of a query at a place, and its mean at a true pose [nats].
struct PartEvidence {
  double score = 0, expected = 0;
};

/// Places with at least this share of the best score are verified densely.
constexpr double kAboutAsWell = 0.75;

/// What speaks for one place by itself.
struct PlaceEvidence {
  double score = 0;          ///< [nats]
  double expected = 0;       ///< score that a true pose would have on average [nats]
  double map_coverage = 1;   ///< share of the query where the map knows anything
  PartEvidence obstacles;    ///< of bird's-eye views: upright surfaces and obstacles
  bool of_surfaces = false;  ///< as in Statistics
  DenseEvidence dense;
};

/// What speaks for and against the best place of one query, or of several together, by whatever
/// method and field it was found.
struct Evidence : PlaceEvidence {
  double runner_up = 0;  ///< score of the best other place; what unseen area scores (0) if none
  double third = 0;      ///< score of the place after that
  std::vector<PlaceEvidence> alternatives;  ///< other places that were verified densely
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

/// Without the statistics of wrong places of the map.
Statistics statisticsOf(const Evidence& evidence);

/// Terms in which the log odds of right against wrong are linear, if every other query is out of
/// the map.
enum Term : std::size_t {
  kConstant,
  kScoreRatio,          ///< logarithm of Statistics::score_ratio
  kLikelihoodMargin,    ///< logarithm of Statistics::likelihood_margin; from the air the margin
                        ///< itself, as a share of 60 nats
  kMapCoverage,         ///< logarithm of Statistics::map_coverage: out-of-map queries fit
                        ///< best where they hang over the edge of the map
  kAboveNull,           ///< inlier ratio above null and threshold, as a share of the
                        ///< self-consistency where that is set; of a narrow view above null
                        ///< only, from the air 0 at most; 0 without convergence
  kConverged,           ///< 1 if the registration converged near the place
  kObstacleOverlap,     ///< Visibility::obstacle_overlap above its threshold
  kMapOverlap,          ///< Visibility::map_overlap
  kMissRatio,           ///< Visibility::miss_ratio below its threshold
  kConflictRatio,       ///< Visibility::conflict_ratio below its threshold
  kFreeSpaceViolation,  ///< negative logarithm of DenseEvidence::free_space_violation
  kDenseMargin,         ///< Statistics::dense_margin
  kDenseMarginTimesAboveNull,  ///< product of both where both are positive
  kLogDenseMargin,             ///< logarithm of the dense margin: an out-of-map query may fit one
                               ///< place of the map only, too
  kWrongPlaceAboveNull,        ///< Statistics::wrong_place_above_null over that of a usual map
  kLikelihoodMarginTimesAboveNull,  ///< in rooms: logarithm of the likelihood margin times the
                                    ///< inlier ratio above null and threshold, as a multiple of
                                    ///< Statistics::wrong_place_above_null, where that is positive
  kTerms
};

/// Log odds x = weights . terms, and x + sharpness * max(0, x - knee)^2 above the knee: where all
/// terms agree, right answers are more frequent than a sum of dependent terms says.
struct EvidenceWeights {
  std::array<double, kTerms> of{};
  double knee = 0, sharpness = 0;

  double& operator[](Term term) { return of[term]; }
  double operator[](Term term) const { return of[term]; }
  double logOdds(const std::array<double, kTerms>& terms) const;
  /// The x of which these are the log odds.
  double linearPart(double log_odds) const;
};

/// What an answer can be judged by, each with weights of its own.
enum EvidenceKind : std::size_t {
  kBareGraph,   ///< the score of vertices
  kPlaceAlone,  ///< the score of surfaces
  kScan,        ///< a registration as well
  kRooms,       ///< that of a camera in rooms
  kGlimpse,     ///< that of a few frames of a camera outdoors
  kOverlap,     ///< the overlap of map and query as well
  kAerial,      ///< the same from the air
  kEvidenceKinds
};

EvidenceKind kindOf(const Statistics& statistics);

/// The weights of each kind, fitted together because terms depend on one another. Terms that a kind
/// of evidence lacks weigh 0.
struct VerdictModel {
  std::array<EvidenceWeights, kEvidenceKinds> of_kind;

  EvidenceWeights& operator[](EvidenceKind kind) { return of_kind[kind]; }
  const EvidenceWeights& operator[](EvidenceKind kind) const { return of_kind[kind]; }
  const EvidenceWeights& weightsFor(const Statistics& s) const { return of_kind[kindOf(s)]; }
};

/// A term is 0 where its evidence was not measured.
std::array<double, kTerms> termsOf(const Statistics& statistics);

/// Dense score of a place, to compare the places of one query [nats]: inlier ratio above null, map
/// overlap and free-space violation. For an out-of-map query a copy of the map is as good as the
/// map; of two places the one that fits to the centimetre is right. Values that are set in `best`,
/// the dense evidence of the best place, are compared.
double denseScore(const PlaceEvidence& place, const DenseEvidence& best);

/// The model that the program comes with, config/verdict.txt.
const VerdictModel& defaultVerdictModel();
/// That of the options; throws Error if it cannot be read.
VerdictModel verdictModelOf(const VerdictOptions& options);
/// Throws Error with path and line if the file is not one that toText() made.
VerdictModel readVerdictModel(const std::string& path);
std::string toText(const VerdictModel& model);

/// An answer with its label for training: right or wrong.
struct JudgedStatistics {
  Statistics statistics;
  bool right = false;
  std::size_t group = 0;  ///< answers of one world or recording
};
/// Logistic regression with a small ridge and monotone signs, all right answers weighing as much as
/// all wrong ones. Its odds are then calibrated by leave-one-group-out cross-validation. Each set
/// of weights is learned from all answers that have its evidence; where none has, the weights stay
/// those of the program. Throws Error if right or wrong ones are missing.
VerdictModel fitVerdictModel(const std::vector<JudgedStatistics>& answers);

struct Verdict {
  Status status = Status::rejected;
  double confidence = 0;
  std::string reason;
  ReasonCode reason_code = ReasonCode::out_of_map;
  Witnesses witnesses;
  Statistics statistics;
};

/// One formula and one scale for views, bare graphs, walks and sequences.
///
/// Without a registration the odds grow with the logarithm of the likelihood-ratio margin (s1 - s2)
/// ln(s1 / s2), as 60 nats over the second-best place are much over 30 and little over 600. With
/// one they grow with the margin of dense scores over the other places that were verified, with map
/// coverage, and with the inlier ratio above null or, where these are set, the overlaps and
/// conflicts of query and map. Correspondences add nothing to these (measured) and are reported
/// only.
///
/// How unlikely evidence is at a wrong place depends on the map: streets of one plan and rooms of
/// one floor fit each other closely. `wrong_places` samples that null hypothesis in the map at hand
/// (empty: a usual map). The confidence includes the probability that the error of the pose, by its
/// own covariance, is below 3 m.
Verdict judge(const Evidence& evidence, const VerdictOptions& options,
              const VerdictModel& model = defaultVerdictModel(),
              const std::vector<WrongPlace>& wrong_places = {});

/// Of the position of a pose in the plane, where it is known least [m].
double horizontalSigma(const Matrix6d& covariance);

/// Makes it that of an answer.
void setVerdict(Verdict verdict, Localization& answer);
/// Takes an acceptance back: the answer is rejected, and likelier wrong than right.
void refuse(ReasonCode code, std::string reason, Localization& answer);

}  // namespace xview::verify
