// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace xview {

enum class PngColor { grey = 0, rgb = 2, palette = 3, grey_alpha = 4, rgba = 6 };

struct PngHeader {
  int width = 0;
  int height = 0;
  int bits = 0;  ///< per channel
  PngColor color = PngColor::grey;
  bool interlaced = false;
  bool has_transparent_color = false;

  struct Piece {
    std::size_t begin, size;
  };
  std::vector<Piece> data;  ///< where the packed pixels are in the file
};

/// Walks the chunks of a PNG: signature, lengths, checksums, end. Throws Error with the byte where
/// it is damaged. Done before the decoder sees the file, because libpng writes its complaints to
/// stderr and believes any size in a header.
PngHeader checkPng(const std::string& path, const std::vector<unsigned char>& bytes);

/// "16-bit grey", "8-bit RGB", …
std::string describe(const PngHeader& header);

}  // namespace xview
