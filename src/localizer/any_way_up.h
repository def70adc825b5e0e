// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <mutex>
#include <optional>
#include <vector>

#include "match/feature_matching.h"
#include "xview/localizer.h"
#include "xview/map/semantic_map.h"

namespace xview {

/// Local features of the points of a map, for queries whose direction of gravity does not meet that
/// of the map, and for small views. They are made for the first query that asks for them. The map,
/// at canonical scale, must outlive the index.
class FeatureIndex {
 public:
  FeatureIndex(const map::SemanticMap& map, int threads) : map_(map), threads_(threads) {}

  /// Whether the query is asked: both have points, and neither has more surface than some rooms,
  /// which bounds the time; in towns only clouds, of which nobody knows how they lie.
  bool takes(const Query& query) const;
  /// A query that it takes, as features see it.
  match::FeatureCloud described(const Query& query) const;
  /// Poses of six degrees of freedom, the likeliest first. Thread-safe.
  std::vector<match::FeaturePose> propose(const match::FeatureCloud& query) const;

 private:
  const match::FeatureCloud* ofMap() const;

  const map::SemanticMap& map_;
  int threads_;
  mutable std::once_flag made_;
  mutable std::optional<match::FeatureCloud> of_map_;
};

/// The query as it stands when `up`, a unit vector in its frame, points up: its view, its graph and
/// what classes it has from shapes are made anew from its points. `options` are in its lengths.
Query standingQuery(const Query& query, const Eigen::Vector3d& up, const Options& options);

}  // namespace xview
