// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cstddef>
#include <vector>

#include "xview/base/graph.h"

namespace xview::match {

/// The correspondences that one pose explains, where most are wrong: sample consensus
/// draws three of 900 pairs of which one in a hundred is right in vain.
///
/// Two correspondences agree if they join different vertices that are as far apart in query as in
/// map, within `tolerance_m`, and not nearer than that: along the ground and in height if both
/// frames have z up (`upright`), else in space. The two vote for a pose with the number of
/// correspondences that agree with both (Chen et al., SC2-PCR, CVPR 2022); from the pairs with most
/// votes, and a third if z is not up, poses are made, and the one that most query vertices support
/// stays. What ends within twice the tolerance under that pose is kept, in the order given. Of more
/// than 3000 correspondences the first ones of every query vertex take part. Nothing is random.
/// Positions that are not finite agree with nothing. Empty if no three correspondences agree.
std::vector<Correspondence> consistentCorrespondences(
    const std::vector<Eigen::Vector3d>& query, const std::vector<Eigen::Vector3d>& map,
    const std::vector<Correspondence>& correspondences, double tolerance_m, bool upright);

/// A point of a query and that of a map for which it is taken, with the unit normals of their
/// surfaces, on either side.
struct PointMatch {
  Eigen::Vector3d query, map, query_normal, map_normal;
};

/// A pose that some matches agree about.
struct ConsistentPose {
  Eigen::Isometry3d T_map_query = Eigen::Isometry3d::Identity();
  std::size_t support = 0;  ///< matches that it explains
};

/// Whether two poses put a point of the query within `near` of one place, turned alike.
bool isOnePose(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, const Eigen::Vector3d& point,
               double near);
/// The first `most` of sorted poses that differ from all before them.
template <class Pose>
std::vector<Pose> distinctPoses(const std::vector<Pose>& sorted, const Eigen::Vector3d& point,
                                double near, std::size_t most) {
  std::vector<Pose> distinct;
  for (const Pose& pose : sorted) {
    const auto is_one = [&](const Pose& other) {
      return isOnePose(pose.T_map_query, other.T_map_query, point, near);
    };
    if (distinct.size() < most && std::none_of(distinct.begin(), distinct.end(), is_one))
      distinct.push_back(pose);
  }
  return distinct;
}

/// Poses of six degrees of freedom that explain matches of which most are wrong, those with most
/// support first; `most` at most, each at another place than those before it. Two matches agree if
/// their points are as far apart in query as in map, within `tolerance_m`, and their normals make
/// the same angle. Around each of those matches that most pairs speak for, the ones that share most
/// agreeing matches with it make a pose (SC2-PCR, as above), which is fitted to its supporters. Of
/// more than 3000 matches an even share takes part. Nothing is random.
std::vector<ConsistentPose> consistentPoses(const std::vector<PointMatch>& matches,
                                            double tolerance_m, std::size_t most);

}  // namespace xview::match
