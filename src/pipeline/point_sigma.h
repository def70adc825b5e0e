// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "xview/mapper.h"

namespace xview {

/// Distance of a point of a frame from the sensor [m]; 0 for clouds, which do not tell it.
float rangeOf(const FrameDigest& frame, std::size_t i);

/// Adds the points of a frame whose positions are known well enough to a cloud. Returns how many.
std::size_t appendKnownPoints(const FrameDigest& frame, double max_sigma_m, LabelledCloud& cloud);

}  // namespace xview
