// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

#include "xview/types/frame.h"

namespace xview {

/// What becomes of the pixels of one frame in another one, if depths times a scale and the poses
/// are right.
struct DepthAgreement {
  double visible = 0;   ///< share of the pixels that the other frame should see
  double agreeing = 0;  ///< share of these that it measures there, within 5 %
};

DepthAgreement agreementOfDepths(const Frame& a, const Frame& b, double scale);

using FramePair = std::pair<Frame, Frame>;

/// Frames of three places of a recording between which the camera has moved by half a metre or
/// more; fewer where it stood.
std::vector<FramePair> movedPairs(const FrameSource& source);

/// The mean of the pairs.
DepthAgreement agreementOf(const std::vector<FramePair>& pairs, double scale);

}  // namespace xview
