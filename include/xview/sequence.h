// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>

#include "xview/localizer.h"

namespace xview {

/// What successive queries of one recording say together.
struct SequenceAnswer {
  Localization fix;    ///< with the history; hypotheses are scored by all windows that count
  Localization alone;  ///< what this query says by itself
  int windows =
      1;  ///< windows that count: this one and earlier ones that share no frame with a later one
  double score = 0;        ///< of the best place, summed over them [nats]
  double runner_up = 0;    ///< of the best other place
  bool restarted = false;  ///< this query contradicts the history, which was dropped
};

/// Brings the hypotheses of successive queries to one frame by their common odometry, and asks
/// evaluates every hypothesis for every query: a place that fits one of them only falls behind, the
/// right one accumulates evidence.
///
/// The queries must be windows of one recording, in order (one odometry frame). Evidence counts
/// once: of windows that overlap only the later one is summed. A place is accepted by the verdict
/// of single queries on the sums, with needs that grow with the root of the number of windows, and
/// on the mean of their dense evidence; and only if the current query agrees with it. What that
/// query accepts by itself is not accepted if all together find it likelier wrong than right.
/// Queries are kept whole as long as they count. Not for method walks.
class Sequence {
 public:
  /// The localizer must outlive the sequence. Of the options, those of odometry and verdict
  /// and places.hypotheses are used. Throws UsageError with method walks.
  Sequence(const Localizer& localizer, const Options& options);
  explicit Sequence(const Localizer& localizer) : Sequence(localizer, localizer.options()) {}
  Sequence(Localizer&&, const Options&) = delete;
  explicit Sequence(Localizer&&) = delete;
  ~Sequence();

  /// `first` and `last` (half-open): positions of the frames of the query in the recording. The
  /// pose of the answer is that of the last frame, in the map frame [m]. What a Budget cuts tells
  /// the next windows nothing. Throws as Localizer::localize().
  SequenceAnswer add(const Query& query, std::size_t first, std::size_t last);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace xview
