// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "pipeline/free_path.h"
#include "pipeline/level_on_map.h"
#include "pipeline/object_path.h"
#include "pipeline/place_path.h"
#include "pipeline/pose_prior.h"
#include "pipeline/pose_refinement.h"
#include "pipeline/walk_path.h"
#include "pipeline/walk_proposer.h"

namespace xview {

/// What is made once per map, and the paths that a query may take through it. Map and queries stand
/// upright, but for those of localizeFreely(). Options must outlive it, and so must the map.
class UprightLocalizer {
 public:
  /// `map_up_sigma_rad`: how well the up of the map is known.
  UprightLocalizer(const SemanticMap& map, double map_up_sigma_rad, const Options& options);

  /// Returns the rotation that the place which was found turns the query upright with.
  Eigen::Quaterniond localize(const Query& query, const Priors& priors, double rival_score,
                              Localization& answer) const;
  /// The same for a query of unknown up.
  Eigen::Quaterniond localizeFreely(const Query& query, const Priors& priors,
                                    Localization& answer) const;
  /// Takes back an acceptance that priors alone are good for.
  void doubtPriors(const Query& query, const Priors& priors, Localization& answer) const;
  /// Returns the same as localize().
  Eigen::Quaterniond describe(const Query& query, const PoseCheck& place,
                              Localization& answer) const;

  /// The best place by one search, without a verdict; score 0 if there is none.
  PoseCheck bestPlace(const Query& query, const Priors& priors) const;
  std::vector<PoseCheck> check(const Query& query,
                               const std::vector<Eigen::Isometry3d>& T_map_query,
                               double reach_m) const;
  Explanation explain(const Query& query, const std::vector<Correspondence>& kept,
                      const Eigen::Isometry3d& T_map_query) const;

  const FreePath& freePath() const { return free_path_; }
  const LabelSet& labels() const { return map_.labels; }

 private:
  bool takesPlacePath(const Query& query) const { return surfaces_ && !query.plan.known.empty(); }
  /// The query in the surface field; null without one.
  std::unique_ptr<search::FieldQuery> inField(const Query& query) const;
  double upSigma(const Query& query) const;
  std::optional<LevelledQuery> levelled(const Query& query, const search::FieldQuery* in_field,
                                        const Eigen::Isometry3d& T_map_query) const;
  Eigen::Quaterniond refine(const Query& query, const search::FieldQuery* in_field,
                            Localization& answer) const;
  Eigen::Quaterniond finish(const Query& query, const search::FieldQuery* in_field,
                            const Priors& priors, Localization& answer) const;

  const SemanticMap& map_;
  const double map_up_sigma_rad_;
  const Options& options_;
  const WalkProposer walks_;
  const std::unique_ptr<const search::Field> surfaces_;
  const WalkPath walk_path_;
  const PlacePath place_path_;
  const ObjectPath object_path_;
  const FreePath free_path_;
  const PoseRefinement refinement_;
};

}  // namespace xview
