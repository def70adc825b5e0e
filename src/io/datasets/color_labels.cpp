// SPDX-License-Identifier: BSD-3-Clause
#include "color_labels.h"

#include "io/image_decoding.h"
#include "xview/types/error.h"

namespace xview {

ColorTable colorTable(const LabelSet& labels) {
  ColorTable table;
  for (const auto& [id, info] : labels.classes()) {
    const auto& [red, green, blue] = info.color;
    table.emplace(std::uint32_t{red} << 16 | std::uint32_t{green} << 8 | blue,
                  static_cast<std::uint16_t>(id));
  }
  return table;
}

LabelImage labelsOfColors(const cv::Mat& image, const ColorTable& table, const std::string& path) {
  const int channels = image.channels();
  if (image.depth() != CV_8U || channels < 3) {
    throw Error(path, "expected class colours as 8-bit unsigned, 3 channels, found " +
                          describePixels(image));
  }
  LabelImage labels(image.cols, image.rows);
  for (int y = 0; y < image.rows; ++y) {
    const std::uint8_t* pixel = image.ptr<std::uint8_t>(y);  // blue, green, red
    for (int x = 0; x < image.cols; ++x, pixel += channels) {
      const auto found =
          table.find(std::uint32_t{pixel[2]} << 16 | std::uint32_t{pixel[1]} << 8 | pixel[0]);
      labels.at(x, y) = found == table.end() ? std::uint16_t{0} : found->second;
    }
  }
  return labels;
}

}  // namespace xview
