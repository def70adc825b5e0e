// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "xview/types/image.h"

namespace xview {

/// Averages depths of a noisy camera where that does no harm. The inverse of planar depth is an
/// affine function of the pixel on every plane (along the rays it nearly is, over a few pixels),
/// and it is what errs evenly: noisy depths themselves are too far on average, by their variance
/// over the depth, 0.15 m for a stereo camera that is good to 2.5 m at 45 m. So the pixels of one
/// label in windows of 20, 12 or 4 pixels are replaced by a plane, the largest that noise alone
/// explains.
///
/// `inverse_depth_sigma` [1/m] is the noise of single pixels; nothing happens if it is 0. What is
/// known to `good_m` stays as it is, and so does what no plane explains: leaves, edges, single
/// wrong depths. Pixels without depth stay without.
///
/// A sensor that tells depths up to some limit only tells too short ones of a surface near it:
/// planes are moved to where the measurements that are told come from, and what lies so near to the
/// limit that most of it is not told loses its depth.
void smoothDepth(DepthImage& depth, const LabelImage& labels, double inverse_depth_sigma,
                 double good_m);

}  // namespace xview
