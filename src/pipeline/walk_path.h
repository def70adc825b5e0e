// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "pipeline/pose_prior.h"
#include "pipeline/walk_proposer.h"
#include "xview/localizer.h"

namespace xview {

/// The paper's localization: descriptors of walks against those of the whole map.
class WalkPath {
 public:
  /// All must outlive the path.
  WalkPath(const SemanticMap& map, const WalkProposer& walks, const Options& options)
      : map_(map), walks_(walks), options_(options) {}

  /// Fills everything but the refined pose and its covariance.
  void localize(const Query& query, const Priors& priors, Localization& answer) const;

 private:
  const SemanticMap& map_;
  const WalkProposer& walks_;
  const Options& options_;
};

}  // namespace xview
