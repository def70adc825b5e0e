// SPDX-License-Identifier: BSD-3-Clause
#include "png_pixels.h"

#include <libdeflate.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <memory>

namespace xview {
namespace {

using Byte = unsigned char;

/// What the rows of a PNG are made of.
struct Layout {
  int channels = 0;
  std::size_t pixel_bytes = 0;
  std::size_t row_bytes = 0;  ///< without the byte in front that names the filter
};

Layout layoutOf(const PngHeader& header) {
  Layout layout;
  layout.channels = header.color == PngColor::grey ? 1 : header.color == PngColor::rgb ? 3 : 4;
  layout.pixel_bytes = static_cast<std::size_t>(layout.channels * header.bits / 8);
  layout.row_bytes = layout.pixel_bytes * static_cast<std::size_t>(header.width);
  return layout;
}

bool isPlain(const PngHeader& header) {
  const bool known_color = header.color == PngColor::grey || header.color == PngColor::rgb ||
                           header.color == PngColor::rgba;
  return known_color && (header.bits == 8 || header.bits == 16) && !header.interlaced &&
         !header.has_transparent_color;
}

/// The data chunks of the file, one after the other, unpacked; empty if they do not hold `size`
/// bytes.
std::vector<Byte> inflate(const PngHeader& header, const std::vector<Byte>& bytes,
                          std::size_t size) {
  std::vector<Byte> joined;
  const Byte* packed = nullptr;
  std::size_t packed_size = 0;
  if (header.data.size() == 1) {
    packed = bytes.data() + header.data[0].begin;
    packed_size = header.data[0].size;
  } else {
    for (const PngHeader::Piece& piece : header.data) {
      const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(piece.begin);
      joined.insert(joined.end(), begin, begin + static_cast<std::ptrdiff_t>(piece.size));
    }
    packed = joined.data();
    packed_size = joined.size();
  }
  const std::unique_ptr<libdeflate_decompressor, void (*)(libdeflate_decompressor*)> inflater(
      libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
  std::vector<Byte> rows(size);
  const auto result = libdeflate_zlib_decompress(inflater.get(), packed, packed_size, rows.data(),
                                                 rows.size(), nullptr);
  if (result != LIBDEFLATE_SUCCESS) rows.clear();
  return rows;
}

// The filters of the PNG specification, section 9, undone in place. `kStep` is the size of a pixel,
// known to the compiler so that it keeps the pixel on the left in registers.

template <std::size_t kStep>
void undoSub(Byte* row, std::size_t size) {
  Byte left[kStep] = {};
  for (std::size_t i = 0; i < size; i += kStep) {
    for (std::size_t c = 0; c < kStep; ++c) row[i + c] = left[c] += row[i + c];
  }
}

void undoUp(Byte* row, const Byte* above, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) row[i] = static_cast<Byte>(row[i] + above[i]);
}

template <std::size_t kStep>
void undoAverage(Byte* row, const Byte* above, std::size_t size) {
  Byte left[kStep] = {};
  for (std::size_t i = 0; i < size; i += kStep) {
    for (std::size_t c = 0; c < kStep; ++c) {
      row[i + c] = left[c] = static_cast<Byte>(row[i + c] + (left[c] + above[i + c]) / 2);
    }
  }
}

/// Left, above or above left: the nearest to left + above - above left.
Byte paeth(int left, int above, int corner) {
  const int to_left = std::abs(above - corner), to_above = std::abs(left - corner);
  const int to_corner = std::abs(left + above - 2 * corner);
  const int upper = to_above <= to_corner ? above : corner;
  return static_cast<Byte>(to_left <= to_above && to_left <= to_corner ? left : upper);
}

template <std::size_t kStep>
void undoPaeth(Byte* row, const Byte* above, std::size_t size) {
  Byte left[kStep] = {}, corner[kStep] = {};
  for (std::size_t i = 0; i < size; i += kStep) {
    for (std::size_t c = 0; c < kStep; ++c) {
      const Byte guess = paeth(left[c], above[i + c], corner[c]);
      corner[c] = above[i + c];
      row[i + c] = left[c] = static_cast<Byte>(row[i + c] + guess);
    }
  }
}

template <std::size_t kStep>
bool undoFilter(int filter, Byte* row, const Byte* above, std::size_t size) {
  switch (filter) {
    case 0:
      return true;
    case 1:
      undoSub<kStep>(row, size);
      return true;
    case 2:
      undoUp(row, above, size);
      return true;
    case 3:
      undoAverage<kStep>(row, above, size);
      return true;
    case 4:
      undoPaeth<kStep>(row, above, size);
      return true;
    default:
      return false;
  }
}

bool undoFilter(std::size_t pixel_bytes, int filter, Byte* row, const Byte* above,
                std::size_t size) {
  switch (pixel_bytes) {
    case 1:
      return undoFilter<1>(filter, row, above, size);
    case 2:
      return undoFilter<2>(filter, row, above, size);
    case 3:
      return undoFilter<3>(filter, row, above, size);
    case 4:
      return undoFilter<4>(filter, row, above, size);
    case 6:
      return undoFilter<6>(filter, row, above, size);
    default:
      return undoFilter<8>(filter, row, above, size);
  }
}

/// Samples in the order of the file to pixels in OpenCV's order.
template <class Sample>
void storeRow(const Byte* row, int channels, cv::Mat& image, int y) {
  const auto sample = [&](std::size_t i) {
    if constexpr (sizeof(Sample) == 1)
      return row[i];
    else
      return static_cast<Sample>(row[2 * i] << 8 | row[2 * i + 1]);
  };
  Sample* out = image.ptr<Sample>(y);
  const auto samples = static_cast<std::size_t>(image.cols * channels);
  if (channels == 1) {
    for (std::size_t i = 0; i < samples; ++i) out[i] = sample(i);
    return;
  }
  const auto step = static_cast<std::size_t>(channels);
  for (std::size_t i = 0; i < samples; i += step) {
    out[i] = sample(i + 2);
    out[i + 1] = sample(i + 1);
    out[i + 2] = sample(i);
    if (channels == 4) out[i + 3] = sample(i + 3);
  }
}

}  // namespace

cv::Mat decodePng(const PngHeader& header, const std::vector<unsigned char>& bytes) {
  if (!isPlain(header)) return {};
  const Layout layout = layoutOf(header);
  const auto height = static_cast<std::size_t>(header.height);
  std::vector<Byte> rows = inflate(header, bytes, (1 + layout.row_bytes) * height);
  if (rows.empty()) return {};
  cv::Mat image(header.height, header.width,
                CV_MAKETYPE(header.bits == 8 ? CV_8U : CV_16U, layout.channels));
  const std::vector<Byte> nothing(layout.row_bytes, 0);
  const Byte* above = nothing.data();
  for (int y = 0; y < header.height; ++y) {
    Byte* row = rows.data() + (1 + layout.row_bytes) * static_cast<std::size_t>(y);
    if (!undoFilter(layout.pixel_bytes, row[0], row + 1, above, layout.row_bytes)) return {};
    above = row + 1;
    if (header.bits == 8)
      storeRow<Byte>(above, layout.channels, image, y);
    else
      storeRow<std::uint16_t>(above, layout.channels, image, y);
  }
  return image;
}

}  // namespace xview
