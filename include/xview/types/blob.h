// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

namespace xview {

/// A connected region of one class (paper, section III-A): the node of a frame graph.
struct Blob {
  std::uint32_t label = 0;
  std::uint32_t instance = 0;                            ///< 0 = none given by the data
  Eigen::Vector3d position = Eigen::Vector3d::Zero();    ///< mean of the points [m]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of the points [m^2]
  Eigen::Vector3d min = Eigen::Vector3d::Zero();         ///< axis-aligned bounds [m]
  Eigen::Vector3d max = Eigen::Vector3d::Zero();
  std::uint32_t points = 0;
  std::int64_t first_frame = 0;
  std::int64_t last_frame = 0;
};

/// Pairs of blobs of one frame, smaller index first, sorted.
using BlobEdges = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

}  // namespace xview
