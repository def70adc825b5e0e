// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <opencv2/core/mat.hpp>
#include <string>

#include "xview/types/image.h"
#include "xview/types/labels.h"

namespace xview {

/// Class id of a colour, 0xRRGGBB.
using ColorTable = std::map<std::uint32_t, std::uint16_t>;

/// The colours of a label set; the smallest id wins where two classes share one.
ColorTable colorTable(const LabelSet& labels);

/// Class ids of an 8-bit colour image; colours that are not in the table become 0. Throws Error for
/// other images.
LabelImage labelsOfColors(const cv::Mat& image, const ColorTable& table, const std::string& path);

}  // namespace xview
