// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "xview/types/frame.h"

namespace xview::graph {

/// Median of the depths that were measured [m]; 0 without any.
double medianDepth(const DepthImage& depth);

/// Averages what a moving camera measured of each pixel of `frame`, in `frame` itself and in
/// `others`, which saw it from nearly the same place. It is inverse depth that errs evenly, so that
/// is what is averaged. What differs from the pixel by more than noise of `inverse_depth_sigma`
/// [1/m] explains is of something else: hidden there, or moving. Pixels without depth stay without.
DepthImage averageDepth(const Frame& frame, const std::vector<const Frame*>& others,
                        double inverse_depth_sigma);

}  // namespace xview::graph
