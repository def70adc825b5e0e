// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace xview {

/// How a segmentation network wants its images, and what its answers mean.
struct NetworkInput {
  int width = 0, height = 0;  ///< size that the network sees [px]; 0 = that of the image
  /// A channel of the network is (value / 255 - mean) / std of a colour; in the order of `order`.
  std::array<double, 3> mean{0, 0, 0}, std{1, 1, 1};
  bool is_rgb = true;              ///< red first; else blue first
  std::vector<std::uint32_t> ids;  ///< class id of each output channel or value; empty = itself
  std::string labels;              ///< the label set of these ids: a shipped name or a file
};

}  // namespace xview
