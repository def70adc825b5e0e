// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace xview {

/// A row-major image of plain numbers. Empty when width or height is 0.
template <class T>
struct Image {
  int width = 0;
  int height = 0;
  std::vector<T> pixels;

  Image() = default;
  Image(int w, int h, T value = T())
      : width(w),
        height(h),
        pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), value) {}

  bool empty() const { return pixels.empty(); }
  T& at(int x, int y) { return pixels[static_cast<std::size_t>(y) * width + x]; }
  const T& at(int x, int y) const { return pixels[static_cast<std::size_t>(y) * width + x]; }
};

using DepthImage = Image<float>;          ///< metres; 0 = no measurement
using LabelImage = Image<std::uint16_t>;  ///< class id, or instance id (0 = none)

}  // namespace xview
