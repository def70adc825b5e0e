// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "xview/mapper.h"

namespace xview {

/// How well the depth of a point of a frame is known [m]; 0 if nothing speaks against it.
inline double pointSigma(const FrameDigest& frame, std::size_t i) {
  if (frame.cloud.ranges.empty()) return 0;
  const double range = frame.cloud.ranges[i];
  return frame.inverse_depth_sigma * range * range;
}

}  // namespace xview
