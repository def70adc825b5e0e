// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace xview::io {

enum class ImageFormat { none, png, tiff, exr, jpeg };

/// What the first bytes of an image say, before anybody makes room for its pixels.
struct ImageHeader {
  ImageFormat format = ImageFormat::none;  ///< none: of another format
  std::uint64_t width = 0, height = 0;     ///< of TIFF, EXR and JPEG; 0 if nothing is said
  /// Pixels that the decoder keeps for one tile of a TIFF or EXR; 0 if it has none.
  std::uint64_t tile_pixels = 0;
  std::uint64_t strip_pixels = 0;  ///< the same of one strip of a TIFF, which may end below it
  std::string damage{};            ///< what contradicts the size of the file; empty if nothing does
};

ImageHeader imageHeader(const std::vector<unsigned char>& bytes);

/// False for a JPEG that ends before its last marker, whose lower part the decoder would make up.
bool endsAsJpeg(const std::vector<unsigned char>& bytes);

}  // namespace xview::io
