// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "search/likelihoods.h"
#include "xview/map/semantic_map.h"
#include "xview/mapper.h"

namespace xview {

/// Counts how far the samples of query windows lie from map samples of their channel, at the true
/// pose and at wrong poses on the road of the map (heading along it or against it, at least 25 m
/// off). `T_map_sensor`: true pose of each frame. Windows of `window_m` metres of travel overlap by
/// two thirds, and are gravity-aligned as queries are (options.gravity), whatever the tilt of their
/// odometry or of the frame of the map.
search::LikelihoodTable learnLikelihoods(const map::SemanticMap& map,
                                         const std::vector<PreprocessedFrame>& frames,
                                         std::vector<Eigen::Isometry3d> T_map_sensor,
                                         double window_m, const Options& options);

}  // namespace xview
