// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "xview/types/camera.h"
#include "xview/types/image.h"

namespace xview {

/// Standard deviation of inverse depth [1/m], so that a depth z is known to z^2 times this. Inverse
/// depth is an affine function of the pixel on every plane, whatever its slant: second differences
/// over a few pixels that are not zero are noise, or an edge, which the median passes over. 0 if
/// too few pixels are measured, or if quantization hides the noise.
double inverseDepthNoise(const DepthImage& depth);

/// Whether that noise is one of single pixels: then neighbours show at least a fifth of it. What
/// differs over a few pixels only are leaves and other small shapes.
bool isNoiseOfPixels(double inverse_depth_noise, const DepthImage& depth);

}  // namespace xview
