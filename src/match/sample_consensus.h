// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "xview/base/graph.h"
#include "xview/options.h"

namespace xview::match {

struct Consensus {
  bool found = false;  ///< other fields are valid only if true
  Eigen::Isometry3d T_map_query = Eigen::Isometry3d::Identity();
  std::vector<Correspondence> inliers;  ///< one per query vertex and one per map vertex
};

/// The pose that pcl::registration::CorrespondenceRejectorSampleConsensus finds, refitted to its
/// supporters in double as long as their number grows. Three traps of that class are handled here:
/// failure looks like "all are inliers, identity", so supporters are recounted, and fewer than
/// min_inliers are no pose; it keeps one target per source index, so each correspondence gets
/// points of its own; its points are single precision, so they are centred first. Its samples are
/// drawn from a fixed seed by one thread: results are repeatable. Positions that are not finite
/// take no part. Inliers on one line leave the rotation about it open: alignPoints reports that.
Consensus rejectBySampleConsensus(const std::vector<Eigen::Vector3d>& query,
                                  const std::vector<Eigen::Vector3d>& map,
                                  const std::vector<Correspondence>& correspondences,
                                  const ConsensusOptions& options);

/// Correspondences that end within inlier_m under the pose: greedy by distance (ties by query, then
/// map vertex), each vertex used once on each side. Ordered by query vertex.
std::vector<Correspondence> supporters(const std::vector<Eigen::Vector3d>& query,
                                       const std::vector<Eigen::Vector3d>& map,
                                       const std::vector<Correspondence>& correspondences,
                                       const Eigen::Isometry3d& T_map_query, double inlier_m);

}  // namespace xview::match
