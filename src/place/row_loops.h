// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

namespace xview {

// What is done with every pixel, compiled with flags of its own.

/// A row of a depth image: p = (towards + x * across) * z + shift, with x the normalised image
/// coordinate of a pixel and z its planar depth.
struct RowOfRays {
  float first_x, step_x;  ///< x of pixel 0, and from pixel to pixel
  float y;                ///< normalised image coordinate of the row
  float towards[3], across[3], shift[3];
  bool depth_is_range;  ///< along the ray instead of planar
  float min_range2, max_range2;
};

enum : std::uint8_t { kMeasured = 0, kNoDepth = 1, kOutOfRange = 2 };

/// Where the pixels of a row are, how far from the sensor, and whether they count (kMeasured...).
/// Points and ranges of pixels without depth mean nothing.
void projectRow(const RowOfRays& row, const float* depth, std::size_t width, float* x, float* y,
                float* z, float* range, std::uint8_t* state);

/// How many depths are measured (positive and finite), and how many of them lie in (above, upto].
struct DepthCounts {
  std::size_t measured = 0, within = 0;
};
DepthCounts countDepths(const float* depth, std::size_t count, float above, float upto);

}  // namespace xview
