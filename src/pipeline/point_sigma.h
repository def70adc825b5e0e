// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "xview/mapper.h"

namespace xview {

/// How well the depth of a point of a frame is known [m]; 0 if nothing speaks against it.
inline double pointSigma(const FrameDigest& frame, std::size_t i) {
  if (frame.cloud.ranges.empty()) return 0;
  const double range = frame.cloud.ranges[i];
  return frame.inverse_depth_sigma * range * range;
}

/// Adds the points of a frame whose depth is known well enough to a cloud, and how well to
/// `sigmas_m`. Returns how many.
std::size_t appendKnownPoints(const FrameDigest& frame, double max_sigma_m, LabelledCloud& cloud,
                              std::vector<float>& sigmas_m);

}  // namespace xview
