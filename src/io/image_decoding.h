// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>

#include "xview/types/image.h"

namespace xview {

/// A PNG, TIFF or EXR exactly as stored: no conversion of depth or channels (colours are in
/// OpenCV's order B G R). Throws Error, also for PNGs of 1, 2 or 4 bits and with a palette, whose
/// values the decoder would change.
cv::Mat decodeImage(const std::string& path);

/// "16-bit unsigned, 3 channels"
std::string describePixels(const cv::Mat& image);

/// One channel of an 8 or 16 bit image; 0 = blue, 1 = green, 2 = red. Throws Error if there is no
/// such channel.
LabelImage channelOf(const cv::Mat& image, int channel, const std::string& path);

}  // namespace xview
