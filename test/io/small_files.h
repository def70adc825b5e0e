// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace xview::test {

// Writers of small files, independent of the library, and of whatever is wrong with them.

/// A PNG of `channels` (1 grey, 2 grey+alpha, 3 RGB, 4 RGBA) and 8 or 16 bits, not compressed;
/// values row by row, channel by channel.
std::string pngBytes(int width, int height, int channels, int bits,
                     const std::vector<std::uint16_t>& values);
/// The same with any colour type and header size; for files that lie.
std::string pngBytes(std::uint32_t width, std::uint32_t height, int color_type, int bits,
                     const std::string& rows, bool interlaced = false);

/// A PFM of one channel; values from the top row down.
std::string pfmBytes(int width, int height, const std::vector<float>& values, bool little_endian);

/// float32 x y z intensity, and SemanticKITTI labels.
std::string scanBytes(const std::vector<float>& numbers);
std::string labelBytes(const std::vector<std::uint32_t>& labels);

/// The bytes of a number as they stand in memory, i.e. little-endian.
template <class T>
std::string raw(T value) {
  return std::string(reinterpret_cast<const char*>(&value), sizeof(T));
}

}  // namespace xview::test
