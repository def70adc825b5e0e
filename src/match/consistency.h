// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
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

}  // namespace xview::match
