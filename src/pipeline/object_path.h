// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <mutex>

#include "pipeline/pose_prior.h"
#include "xview/localizer.h"
#include "xview/search/search.h"

namespace xview {

/// Object search, for graphs without surfaces.
class ObjectPath {
 public:
  /// All must outlive the path.
  ObjectPath(const SemanticMap& map, const Options& options) : map_(map), options_(options) {}

  /// Fills everything but the refined pose and its covariance. Makes the index of the map at the
  /// first call. `rival_score` is that of a place elsewhere that was found otherwise.
  void localize(const Query& query, const Priors& priors, double rival_score,
                Localization& answer) const;
  /// The two steps of it.
  search::SearchResult search(const Query& query, const Priors& priors) const;
  void report(const search::SearchResult& result, double rival_score, Localization& answer) const;
  PoseCheck check(const Query& query, const Eigen::Isometry3d& T_map_query, double reach_m) const;

 private:
  std::unique_ptr<search::FieldQuery> inField(const Query& query) const;

  const SemanticMap& map_;
  const Options& options_;
  mutable std::once_flag made_;
  mutable std::unique_ptr<const search::Field> field_;
};

}  // namespace xview
