// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "pipeline/object_path.h"
#include "pipeline/pose_prior.h"
#include "pipeline/walk_proposer.h"
#include "xview/localizer.h"

namespace xview {

/// Queries of which nobody knows which way is up. Poses with six degrees of freedom from walks and
/// the maximum clique, and the two sides of the layer that the vertices form, say where up may be;
/// the query is searched upright in each way, and the answers are held against one another.
class FreePath {
 public:
  /// All must outlive the path.
  FreePath(const WalkProposer& walks, const ObjectPath& objects, const Options& options)
      : walks_(walks), objects_(objects), options_(options) {}

  /// Fills everything but the refined pose and its covariance, for the query turned by the returned
  /// rotation. Map gravity-aligned, query as it is.
  Eigen::Quaterniond localize(const Query& query, const Priors& priors, Localization& answer) const;

 private:
  const WalkProposer& walks_;
  const ObjectPath& objects_;
  const Options& options_;
};

}  // namespace xview
