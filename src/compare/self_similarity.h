// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "xview/map/semantic_map.h"
#include "xview/options.h"

namespace xview {

/// A stretch of a map as a query in that map, with the noise of a usual query: its scores at its
/// own place and at the best two others [nats].
struct SelfQuery {
  std::size_t place = 0;  ///< position in SelfSimilarity::places
  double window_m = 0;    ///< path length of the query, or width of a piece of a bare graph
  double self = 0;        ///< at its own place, at most the score of a usual second visit
  double wrong = 0, next_wrong = 0;
  std::optional<Eigen::Vector3d> second_best;  ///< where the best wrong place puts it; map frame
  WrongPlace at_second_best;                   ///< evidence there; set by measureNullHypothesis()
  double confidence = 0;                       ///< of such a query
  bool sure = false;                           ///< it would be accepted
};

struct SelfSimilarity {
  struct Place {
    Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< map frame
    std::optional<std::size_t> key_frame;  ///< position in the map's poses; none off its way
    /// Minimum path length from which on every query there is accepted; none if no length is.
    std::optional<double> min_query_length_m;
    /// Where the longest query that is not accepted may be mistaken to be.
    std::optional<Eigen::Vector3d> second_best;
  };
  std::vector<Place> places;       ///< in the order of the map's path
  std::vector<SelfQuery> queries;  ///< by place, then length
  std::vector<double> lengths_m;   ///< that were tried, ascending
};

/// Measures the self-similarity of a map (perceptual aliasing): its own stretches are localized in
/// it. At most `most_places` of them, evenly spread, by several lengths each, so that the time is
/// bounded whatever the size of the map. Deterministic for any number of threads. Nothing for a map
/// that is too small to have two places.
SelfSimilarity measureSelfSimilarity(const map::SemanticMap& map, const Options& options,
                                     std::size_t most_places);

/// Sets the null hypothesis of the verdict, measured in the map at hand: distances at wrong places
/// along its path (search::PathNull), the evidence of a few of its stretches at the best place that
/// is not their own, and their confidence at their own.
/// Bounded like measureSelfSimilarity(); none for a bare graph or a map without a path. Of a map
/// that has grown only stretches from pose `first_pose` on are asked, in proportion to their
/// length, and their answers join the former ones; what is short beside the map has none, and
/// nothing of the map is looked at.
void measureNullHypothesis(map::SemanticMap& map, const Options& options,
                           std::size_t first_pose = 0);

/// How many of a map's own stretches of one length would be accepted by their place alone, at risks
/// of 1e-2, 1e-3 and 1e-4.
struct OwnAcceptance {
  static constexpr std::array<double, 3> kRisks{1e-2, 1e-3, 1e-4};

  double window_m = 0;
  std::size_t stretches = 0;
  std::array<std::size_t, 3> accepted{};
};

/// One per length, ascending; none if the map was not measured.
std::vector<OwnAcceptance> ownAcceptance(const map::SemanticMap& map);

/// How large the margins of wrong places of a map get: of its own stretches, with their own places
/// left out, the mean of the four largest after the very largest, which may be a place that the map
/// shows twice.
struct WrongPlaceMargins {
  double dense = 0, likelihood = 0;  ///< as in Statistics [nats]

  /// Streets or rooms of the map are copies of each other: no usual map reaches such margins.
  bool areOfCopies() const;
};

/// Nothing if fewer than five stretches were measured.
std::optional<WrongPlaceMargins> wrongPlaceMargins(const map::SemanticMap& map);

/// What wrong places of a map score for queries of one length: quantiles over its self queries.
struct WrongScores {
  static constexpr std::array<double, 4> kQuantiles{0.5, 0.9, 0.97, 1};

  double window_m = 0;
  std::size_t queries = 0;
  /// (w1 - w2) ln(w1 / w2) of the best two wrong places: the margin of an out-of-map query [nats].
  std::array<double, 4> likelihood_margin{};
  std::array<double, 4> share{};  ///< w1 over the score of the right place
};

/// One per length, ascending.
std::vector<WrongScores> wrongScores(const SelfSimilarity& self_similarity);

}  // namespace xview
