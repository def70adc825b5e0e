// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "xview/options.h"
#include "xview/types/correspondence.h"
#include "xview/types/graph.h"
#include "xview/types/labels.h"
#include "xview/types/localization.h"

namespace xview {

/// Poses from X-View's descriptors: walks, k best, pairwise consistency, sample consensus of PCL, SVD (paper, sections III-D to III-F).
class WalkProposer {
 public:
  WalkProposer(const SemanticGraph& map, const LabelSet& labels, const Options& options);
  ~WalkProposer();

  struct Proposal {
    bool found = false;
    Eigen::Isometry3d T_map_query = Eigen::Isometry3d::Identity();
    std::vector<Correspondence> inliers;
    double rms_m = 0;
  };
  struct Result {
    std::size_t query_vertices = 0;   ///< of the walk graph
    std::vector<Correspondence> putative;
    std::vector<Proposal> proposals;  ///< best first, places apart from each other
    double descriptors_ms = 0, matching_ms = 0, rejection_ms = 0, pose_ms = 0;
  };
  /// Up to `count` poses; each next one comes from the correspondences that the ones before left over.
  Result propose(const SemanticGraph& query, int count) const;

 private:
  struct Index;
  std::unique_ptr<const Index> index_;
};

}  // namespace xview
