// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <string>

/// The function of the module xview_codecs: an image file in memory as OpenCV decodes it, without
/// conversion. Else the image is empty and `problem` says why. Throws std::bad_alloc.
extern "C" void xviewDecodeImage(const unsigned char* bytes, std::size_t size, cv::Mat& image,
                                 std::string& problem);
