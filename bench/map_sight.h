// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "xview/types/frame.h"

namespace xview::bench {

/// What a recording of depth images could see of posts: what stands behind a house, too far off or
/// beside every image cannot be asked of its map.
class MapSight {
 public:
  /// Keeps all depth images. Of other sensors nothing is known: they see everything.
  explicit MapSight(const FrameSource& source);

  /// Whether a frame saw two of three places on a post with its foot at `p` free, near enough for
  /// thin things. Up is z of the frame of the poses.
  bool contains(const Eigen::Vector3d& p) const;

 private:
  std::vector<Frame> frames_;
};

}  // namespace xview::bench
