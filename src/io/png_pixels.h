// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "png_header.h"

namespace xview {

/// The pixels of a sound PNG (see checkPng), colours in OpenCV's order B G R: the same as OpenCV's
/// decoder in a quarter of the time, which is most of what reading a recording costs. Grey, RGB
/// and RGBA of 8 or 16 bits; an empty image if it is of another kind (interlaced, palette,
/// transparent colour) or if its data cannot be unpacked.
cv::Mat decodePng(const PngHeader& header, const std::vector<unsigned char>& bytes);

}  // namespace xview
