// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "xview/types/image.h"

namespace xview {

/// Lowest inverse depth that the sensor tells, in units of its noise, if the image shows one: many
/// measurements lie just above it. The noise of a surface that the sensor sees whole fades out
/// towards its farthest measurement. None where depths are known to half a metre, because there
/// the steps of a sensor look the same.
std::optional<double> rangeLimit(const DepthImage& depth, double inverse_depth_sigma);

/// Where a surface is of which only the measurements above zero are told, in units of their noise,
/// if these are `seen` above zero on average: the mean of a truncated normal distribution is
/// mu + phi(mu) / Phi(mu). None if it is not one unit above zero: then most of what is told are
/// errors.
std::optional<double> meanOfAll(double seen);

}  // namespace xview
