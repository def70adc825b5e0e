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

/// A stretch of a map as a query in that map, with the noise of a usual query: what it scores at
/// its own place and at the best two others [nats].
struct SelfQuery {
  std::size_t place = 0;  ///< position in SelfSimilarity::places
  double window_m = 0;    ///< way that the query sees, or width of a piece of a bare graph
  double self = 0;        ///< at its own place, but not more than a usual second visit scores
  double wrong = 0, next_wrong = 0;
  std::optional<Eigen::Vector3d> second_best;  ///< where the best wrong place puts it; map frame
  WrongPlace at_second_best;  ///< what it shows there; asked by measureNullHypothesis()
  double confidence = 0;      ///< of such a query
  bool sure = false;          ///< it would be accepted
};

struct SelfSimilarity {
  struct Place {
    Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< map frame
    std::size_t key_frame = 0;  ///< position in the map's poses, or vertices of a bare graph
    /// Length from which on every query there is sure; none if not even the longest is.
    std::optional<double> min_query_length_m;
    /// Where the place may be taken to be, by the longest query that is not sure.
    std::optional<Eigen::Vector3d> second_best;
  };
  std::vector<Place> places;       ///< in the order of the map's way
  std::vector<SelfQuery> queries;  ///< by place, then length
  std::vector<double> lengths_m;   ///< that were tried, ascending
};

/// Asks a map how alike its places are: its own neighbourhoods are looked for in it. At most
/// `most_places` of them, evenly spread, by several lengths each, so that the time is bounded
/// whatever the size of the map. Deterministic for any number of threads. Nothing for a map that is
/// too small to have two places.
SelfSimilarity measureSelfSimilarity(const map::SemanticMap& map, const Options& options,
                                     std::size_t most_places);

/// Sets the null hypothesis of the verdict, measured in the map at hand: a few of its stretches,
/// each asked at the best place that is not its own, and how sure each is of its own place. Bounded
/// like measureSelfSimilarity(); none for a bare graph or a map without a way.
void measureNullHypothesis(map::SemanticMap& map, const Options& options);

/// How many of a map's own stretches of one length would be accepted by their place alone, at risks
/// of 1e-2, 1e-3 and 1e-4.
struct OwnAcceptance {
  static constexpr std::array<double, 3> kRisks{1e-2, 1e-3, 1e-4};

  double window_m = 0;
  std::size_t stretches = 0;
  std::array<std::size_t, 3> accepted{};
};

/// One per length, ascending; none if the map was not asked.
std::vector<OwnAcceptance> ownAcceptance(const map::SemanticMap& map);

/// What wrong places of a map score for queries of one length: quantiles over its self queries.
struct WrongScores {
  static constexpr std::array<double, 4> kQuantiles{0.5, 0.9, 0.97, 1};

  double window_m = 0;
  std::size_t queries = 0;
  /// (w1 - w2) ln(w1 / w2) of the best two wrong places: what a stranger's lead would be [nats].
  std::array<double, 4> likelihood_margin{};
  std::array<double, 4> share{};  ///< w1 over the score of the right place
};

/// One per length, ascending.
std::vector<WrongScores> wrongScores(const SelfSimilarity& self_similarity);

}  // namespace xview
