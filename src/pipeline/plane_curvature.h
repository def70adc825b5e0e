// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "xview/types/frame.h"

namespace xview {

/// How bent ground and houses look, 0 = flat. The inverse of planar depth is an affine function of
/// the pixel on every plane, so its second difference over a tenth of the image is zero, but for
/// noise and edges, which the median passes over. With depth along the ray taken for planar depth,
/// or the other way round, it is one or two percent of the inverse depth, all over a frame of 90
/// degrees.
struct PlaneCurvature {
  double as_given = 0;   ///< with depths as the camera declares them
  double otherwise = 0;  ///< with the other kind of depth
};

/// None if too little ground and houses are seen.
std::optional<PlaneCurvature> curvatureOfPlanes(const Frame& frame, const LabelSet& labels);

/// Whether planes of a recording say that depths are of the other kind than its camera declares: as
/// given they are bent by what the two kinds differ in, otherwise they are flat. False if it cannot
/// be told.
bool planesSayOtherKind(const FrameSource& source);

}  // namespace xview
