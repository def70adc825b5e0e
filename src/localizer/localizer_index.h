// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "localizer/any_way_up.h"
#include "localizer/pose_refinement.h"
#include "localizer/proposer.h"
#include "localizer/query_check.h"
#include "localizer/query_in_map.h"
#include "place/gravity.h"
#include "xview/localizer.h"

namespace xview {

// What the steps of a localization share: localizer.cpp is the way of a query, localizer_frames.cpp
// which way is up and how long a metre is, localizer_checks.cpp what is asked of given poses.

/// Places whose points were registered, in the order of the candidates.
struct RegisteredPlaces {
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();  ///< of the query onto its ground
  std::vector<RefinedPose> places;                           ///< of the turned query
};

/// A place of the query, found with one hypothesis of gravity alignment and scale.
struct TriedFrame {
  FrameHypothesis guess;
  Eigen::Isometry3d T_map_query = Eigen::Isometry3d::Identity();  ///< of the guessed query
  double score = 0;                                               ///< 0 = there is none
};

/// What speaks for the first candidate against the others.
verdict::Evidence evidenceOf(const Candidates& found, const RegisteredPlaces& registered);
/// Places with similar bird's-eye views are told apart by the registration of their points.
void moveLikeliestToFront(Candidates& found, RegisteredPlaces& registered);

/// The refined pose of the best place becomes that of the answer.
void adoptRefinedPose(RegisteredPlaces& registered, Localization& answer);

/// Hypotheses and correspondences of the answer.
void report(const Candidates& found, std::size_t count, Localization& answer);

/// Lengths times a factor.
Eigen::Isometry3d scaled(double factor, Eigen::Isometry3d T);
/// An answer in canonical lengths in those of a place of that scale.
Localization inMetres(Localization answer, double size);

/// What is said of the pose of a query before it is looked for.
struct PoseHints {
  const ExpectedPose* expected = nullptr;         ///< it is nowhere else
  std::vector<match::FeaturePose> features = {};  ///< the first one is registered as well
  const Eigen::Isometry3d* claimed = nullptr;     ///< is judged, whatever the search finds
  double second_best_score = 0;                   ///< of a place elsewhere that is known
};

/// What is made once per map, and the steps of a localization. The map stands upright here.
struct PlaceIndex {
  /// `detail`: that of a map that was reduced.
  PlaceIndex(const map::SemanticMap& given, const Options& all_options, const Method& method,
             const map::CommonDetail& detail = {});

  Localization localize(const Query& given, const PoseHints& hints) const;
  Localization inAlignedFrames(const Query& query, const PoseHints& hints,
                               FrameHypothesis& frame) const;

  FrameHypothesis chooseFrame(const Query& query, const ExpectedPose* expected,
                              double& second_best_score, Timings& timing_ms) const;
  std::vector<FrameHypothesis> frameHypotheses(const Query& query, const ExpectedPose* expected,
                                               Timings& timing_ms) const;
  TriedFrame tried(const Query& query, const FrameHypothesis& guess,
                   const ExpectedPose* expected) const;
  void refineScale(const Query& query, TriedFrame& best) const;

  void matchVertices(const Query& query, Candidates& found, Timings& timing_ms) const;
  RegisteredPlaces registerPlaces(const Query& query, const Candidates& found,
                                  Localization& answer) const;
  void setVisibility(const Query& query, const Query& levelled, Visibility seen,
                     std::optional<double>& self_consistency, RefinedPose& place) const;
  void checkOutsidePrior(const search::FieldQuery& in_field, const verdict::Evidence& inside,
                         Localization& answer) const;
  void leaveAlignedFrames(const Query& query, const FrameHypothesis& frame,
                          Localization& answer) const;
  std::vector<PoseCheck> check(const Query& query, const std::vector<Eigen::Isometry3d>& poses,
                               double reach_m) const;
  Localization describe(const Query& query, const PoseCheck& place) const;
  Explanation explain(const Query& query, const Localization& answer) const;

  verdict::Verdict judged(const verdict::Evidence& evidence) const {
    return verdict::judge(evidence, options.verdict, verdict_model, map.wrong_places);
  }
  bool upIsKnown(const Query& query) const { return gravity.known && query.gravity.known; }
  /// Gravity alignment of the query; a pose of it tells, if nothing else does.
  Eigen::Quaterniond alignmentOf(const Query& query, const Eigen::Isometry3d& T_map_query) const;
  /// A pose of the caller between upright frames, gravity-aligned and right for the last sensor.
  Eigen::Isometry3d toAligned(const Query& query, const Eigen::Isometry3d& T_map_query) const;
  Priors priorsOf(const Query& given, const Query& upright, const ExpectedPose* expected) const;

  const Options options;
  const Gravity gravity;  ///< of the caller's map
  const std::optional<map::SemanticMap> turned;
  const map::SemanticMap& map;
  const bool shapes_only;  ///< what the map has of classes is what shapes tell
  const verdict::VerdictModel verdict_model;
  const PlacePrior prior;
  const std::optional<ScaleRange> scales;
  const match::WalkMatcher walks;
  const PoseRefinement refinement;
  const Method& method;
  const MapFields fields;
  const std::unique_ptr<const PlaceProposer> proposer;
  const FeatureIndex feature_index;
};

}  // namespace xview
