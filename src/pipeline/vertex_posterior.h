// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "xview/localizer.h"
#include "xview/pose/posterior.h"

namespace xview {

/// The back-end of the paper on the pairs that agree with a pose: odometry between the poses of the
/// window, vertices as its graph saw them, their partners in the map.
Posterior vertexPosterior(const Query& query, const SemanticMap& map,
                          const std::vector<Correspondence>& pairs,
                          const Eigen::Isometry3d& T_map_query, const PosteriorOptions& options);

}  // namespace xview
