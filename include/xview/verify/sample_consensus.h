// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "xview/types/correspondence.h"
#include "xview/types/option_field.h"

namespace xview {

struct ConsensusOptions {
  double inlier_m = 3;       ///< a correspondence fits a pose if it ends this near
  int iterations = 10000;
  int min_inliers = 4;       ///< fewer than this is no pose
};

template <class Visitor>
void visit(ConsensusOptions& o, Visitor&& field) {
  field("inlier_m", o.inlier_m, Range{0.001, 1e3}, "a correspondence supports a pose if it ends this near [m]");
  field("iterations", o.iterations, Range{1, 1e8}, "samples drawn by the sample consensus");
  field("min_inliers", o.min_inliers, Range{3, 1e6}, "fewer supporting correspondences are no pose");
}

struct Consensus {
  bool found = false;  ///< other fields are valid only if true
  Eigen::Isometry3d T_map_query = Eigen::Isometry3d::Identity();
  std::vector<Correspondence> inliers;  ///< one per query vertex and one per map vertex, recounted in double by us
  double rms_m = 0;                     ///< of the inliers
};

/// pcl::registration::CorrespondenceRejectorSampleConsensus on the correspondences. That class reports failure as "all are inliers,
/// identity", so the inliers of its pose are recounted here, and fewer than min_inliers are no pose. Points are centred before they
/// become single precision.
Consensus rejectBySampleConsensus(const std::vector<Eigen::Vector3d>& query, const std::vector<Eigen::Vector3d>& map,
                                  const std::vector<Correspondence>& correspondences, const ConsensusOptions& options);

/// Correspondences that end within inlier_m under the pose: greedy by distance, each vertex used once on each side.
std::vector<Correspondence> supporters(const std::vector<Eigen::Vector3d>& query, const std::vector<Eigen::Vector3d>& map,
                                       const std::vector<Correspondence>& correspondences,
                                       const Eigen::Isometry3d& T_map_query, double inlier_m);

}  // namespace xview
