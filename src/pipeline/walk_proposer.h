// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <vector>

#include "pipeline/walk_graph.h"
#include "xview/options.h"
#include "xview/types/correspondence.h"
#include "xview/types/graph.h"
#include "xview/types/labels.h"

namespace xview {

/// A pose that walks propose, with the vertex pairs that agree on it (numbers of the full graphs).
struct WalkProposal {
  Eigen::Isometry3d T_map_query = Eigen::Isometry3d::Identity();
  std::vector<Correspondence> inliers;
  double rms_m = 0;
};

struct WalkProposals {
  std::vector<Correspondence>
      putative;  ///< k best map vertices per query vertex, in numbers of the full graphs
  std::vector<WalkProposal>
      poses;  ///< most inliers first, each from the correspondences that others left over
  double descriptors_ms = 0, matching_ms = 0, rejection_ms = 0, pose_ms = 0;
};

/// Whether up is z in query and map, so that poses turn about it only.
enum class UpKnown { yes, no };

/// Poses from X-View's descriptors: walks, k best, pairwise consistency, sample consensus of PCL,
/// SVD (paper, sections III-D to III-F).
class WalkProposer {
 public:
  /// The map must outlive the proposer.
  WalkProposer(const SemanticGraph& map, const LabelSet& labels, const Options& options);
  ~WalkProposer();

  /// The query as the walks see it.
  WalkGraph queryGraph(const SemanticGraph& query) const;

  /// Up to `count` poses anywhere in the map. Describes the whole map at the first call.
  WalkProposals propose(const WalkGraph& query, int count, UpKnown up = UpKnown::yes) const;
  /// The part of the map within `radius_m` of a place, as the walks see it.
  WalkGraph mapAround(const Eigen::Vector2d& place, double radius_m) const;
  /// The best pose in a part of the map, which is described for this call only.
  WalkProposals proposeIn(const WalkGraph& part, const WalkGraph& query) const;

 private:
  struct Index;
  std::unique_ptr<const Index> index_;
};

}  // namespace xview
