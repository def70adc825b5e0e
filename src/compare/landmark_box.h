// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "xview/base/graph.h"
#include "xview/base/labels.h"

namespace xview {

// At canonical scale (base/semantic_place.h).
constexpr double kPostRadius_m = 0.45;  ///< points of a post are as near to its axis
constexpr double kPostHeight_m = 12;    ///< and not higher
constexpr double kMeet_m = 0.4;         ///< points of two visits on one landmark are as near
constexpr double kSameObject_m = 0.5;   ///< and their vertices

inline bool isPost(Kind kind) { return isPoleLike(kind) || kind == Kind::trunk; }

/// Where the points of a landmark are; frame of its visit.
inline Eigen::AlignedBox3d boxOf(const Vertex& v, bool is_post) {
  if (is_post) {
    const Eigen::Vector3d side(kPostRadius_m, kPostRadius_m, 0);
    return Eigen::AlignedBox3d(v.position - side, v.position + side)
        .extend(v.position + Eigen::Vector3d(0, 0, kPostHeight_m));
  }
  const Eigen::Vector3d half = v.extent / 2 + Eigen::Vector3d::Constant(kMeet_m / 2);
  return {v.position - half, v.position + half};
}

}  // namespace xview
