// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "xview/base/frame.h"

namespace xview {

/// Standard deviation of inverse depth [1/m], so that a depth z is known to z^2 times this. Inverse
/// depth is an affine function of the pixel on every plane, whatever its slant: second differences
/// over a few pixels that are not zero are noise, or an edge, which the median passes over. 0 if
/// too few pixels are measured, or if quantization hides the noise.
double inverseDepthNoise(const DepthImage& depth);

/// Sets the standard deviations of points that a camera with that noise measured from `p_sensor`,
/// in the frame of the cloud; without noise nothing changes.
void setSigmas(double inverse_depth_noise, const Eigen::Vector3d& p_sensor, LabelledCloud& cloud);

/// Whether that noise is one of single pixels: then neighbours show at least a fifth of it. What
/// differs over a few pixels only are leaves and other small shapes.
bool isNoiseOfPixels(double inverse_depth_noise, const DepthImage& depth);

constexpr double kKnownWell_m = 0.05;  ///< depths with less noise are not smoothed

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
void smoothDepth(DepthImage& depth, const LabelImage& labels, double inverse_depth_sigma,
                 double good_m);

/// Median of the depths that were measured [m]; 0 without any.
double medianDepth(const DepthImage& depth);

/// Averages what a moving camera measured of each pixel of `frame`, in `frame` itself and in
/// `others`, which saw it from nearly the same place. It is inverse depth that errs evenly, so that
/// is what is averaged. What differs from the pixel by more than noise of `inverse_depth_sigma`
/// [1/m] explains is of something else: hidden there, or moving. Pixels without depth stay without.
DepthImage averageDepth(const Frame& frame, const std::vector<const Frame*>& others,
                        double inverse_depth_sigma);

}  // namespace xview
