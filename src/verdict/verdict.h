// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "xview/base/localization.h"
#include "xview/options.h"

namespace xview::verdict {

/// Places with at least this share of the best score are verified densely.
constexpr double kAboutAsWell = 0.75;
/// Map overlap between those of right and of wrong places, on the ground.
constexpr double kUsualMapOverlap = 0.35;

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
  int paired = 0;              ///< of these, how many have a partner at the best place
  int kept = 0;                ///< correspondences that survive sample consensus at the best place
  int with_candidates = 0;     ///< vertices that had a candidate there
  double kept_under_null = 0;  ///< how many of these would keep one at a wrong place
  double kept_if_true = 0;     ///< chance that one of these keeps one at the true place
  double sigma_m = 0;          ///< as in Statistics
  std::optional<double> feature_margin, storeys, other_storey;  ///< as in Statistics

  /// The runner-up scores so well that it must be asked whether points agree there as well.
  bool secondBestIsClose() const { return runner_up > 0.5 * score; }
};

/// Without the statistics of wrong places of the map.
Statistics statisticsOf(const Evidence& evidence);

/// Terms in which the log odds of right against wrong are linear, if every other query is out of
/// the map. More of each makes an answer likelier, but for kWrongPlaceAboveNull. What was not
/// measured is as usual.
enum Term : std::size_t {
  kConstant,
  kMargin,       ///< logarithms of the margins over the other places of the query, its null sample;
                 ///< of bare graphs times the share of vertices that are found
  kInlierRatio,  ///< logarithm of the inlier ratio above null over that of wrong places of the map
  kOverlap,      ///< overlap of query and map, both ways, over the usual one; where the map overlap
                 ///< is not known, how far the query fits the map less than it fits itself
  kMapCoverage,  ///< logarithm of Statistics::map_coverage: out-of-map queries fit best where they
                 ///< hang over the edge of the map
  kFreeSpace,    ///< negative logarithm of the free-space violation over the usual one
  kWrongPlaceAboveNull,  ///< Statistics::wrong_place_above_null over that of a usual map: where
                         ///< wrong places fit closely, all evidence says less, the less so
                         ///< the more closely than they the best place fits
  kTerms
};

/// The name of a term in files of models.
const char* toString(Term term);

/// Weights of terms, each with its sign; a term that does not count weighs 0.
struct EvidenceWeights {
  std::array<double, kTerms> of{};

  double& operator[](Term term) { return of[term]; }
  double operator[](Term term) const { return of[term]; }
  double logOdds(const std::array<double, kTerms>& terms) const;
};

/// One set for all that was registered: points or views, from the ground, in rooms or from the air;
/// one for the place by itself: bare graphs, and answers of views before their registration.
struct VerdictModel {
  EvidenceWeights registered, bare;

  const EvidenceWeights& weightsFor(const Statistics& s) const {
    return s.dense.registered() ? registered : bare;
  }
};

std::array<double, kTerms> termsOf(const Statistics& statistics);
/// By the terms, the second-best place and the covariance of the pose, in [0, 1].
double confidenceOf(const Statistics& statistics, const VerdictModel& model);

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
/// all wrong ones. Its odds are then calibrated by leave-one-group-out cross-validation: of answers
/// that are accepted at a risk, as large a share is wrong. Either set of weights is learned from
/// all answers that have its evidence; where none has, it stays that of the program. Throws Error
/// if right or wrong ones are missing.
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
/// What carries over from one make of worlds and sensors to another are margins over the other
/// places of the same query in the same map, which are its null sample; shares of what agrees
/// (inlier ratio, overlap, coverage, free space) have a level of their own with every sensor and
/// weigh less. Correspondences add nothing to these (measured) and are reported only.
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
/// Takes the acceptance of a Verdict or a Localization back: it is rejected, and likelier wrong
/// than right.
template <class Judged>
void refuse(ReasonCode code, std::string reason, Judged& judged) {
  constexpr double kLessThanEven = 0.49;
  judged.status = Status::rejected;
  judged.confidence = std::min(judged.confidence, kLessThanEven);
  judged.reason = std::move(reason);
  judged.reason_code = code;
}

}  // namespace xview::verdict
