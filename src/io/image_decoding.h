// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "xview/base/frame.h"
#include "xview/base/labels.h"

namespace xview::io {

/// Called with width and height when the header of an image is read, before anybody makes room for
/// its pixels; throws Error if they cannot be.
using SizeCheck = std::function<void(std::int64_t width, std::int64_t height)>;
/// For images of which nothing is known: up to 67 million pixels.
SizeCheck anySize(const std::string& path);

/// A PNG, TIFF, EXR or JPEG exactly as stored: no conversion of depth or channels (colours are in
/// OpenCV's order B G R). Throws Error, also for PNGs of 1, 2 or 4 bits and with a palette, whose
/// values the decoder would change.
cv::Mat decodeImage(const std::string& path, const SizeCheck& check);

/// Depth [m] of an image with one channel: 16 bits times the scale, or floats; values that are not
/// finite or negative become 0. Throws Error for other images.
DepthImage depthOfPixels(const cv::Mat& image, double depth_scale, const std::string& path);

/// readLabels() of an image whose size is known.
LabelImage readLabels(const std::string& path, const SizeCheck& check);

/// "16-bit unsigned, 3 channels"
std::string describePixels(const cv::Mat& image);

/// One channel of an 8 or 16 bit image; 0 = blue, 1 = green, 2 = red. Throws Error if there is no
/// such channel.
LabelImage channelOf(const cv::Mat& image, int channel, const std::string& path);

/// Class id of a colour, 0xRRGGBB.
using ColorTable = std::map<std::uint32_t, std::uint16_t>;
/// The colours of a label set; the smallest id wins where two classes share one.
ColorTable colorTable(const LabelSet& labels);
/// Class ids of an 8-bit colour image; colours that are not in the table become 0. Throws Error for
/// other images.
LabelImage labelsOfColors(const cv::Mat& image, const ColorTable& table, const std::string& path);

/// A portable float map of one channel ("Pf"). Rows are stored from the bottom up; a negative scale
/// means little endian, and its size is not applied (writers do not agree what it means). Values as
/// stored. Throws Error.
Image<float> readPfm(const std::string& path);

enum class PngColor { grey = 0, rgb = 2, palette = 3, grey_alpha = 4, rgba = 6 };

struct PngHeader {
  int width = 0;
  int height = 0;
  int bits = 0;  ///< per channel
  PngColor color = PngColor::grey;
  bool interlaced = false;

  struct Piece {
    std::size_t begin, size;
  };
  std::vector<Piece> data;  ///< where the packed pixels are in the file
};

/// Walks the chunks of a PNG: signature, lengths, checksums, end. Throws Error with the byte where
/// it is damaged. Done before the decoder sees the file, because libpng writes its complaints to
/// stderr and believes any size in a header.
PngHeader checkPng(const std::string& path, const std::vector<unsigned char>& bytes);

/// The pixels of a sound PNG, colours in OpenCV's order B G R, grey with alpha as B G R alpha. Own
/// code because libraries take several times longer for most of reading a recording: 16-bit depth
/// of 320x240 pixels 0.28 ms here, 1.06 ms with libspng 0.7.3, 1.07 ms with OpenCV; 8-bit labels
/// 0.04, 0.10, 0.13 ms. 8 or 16 bits without a palette; a transparent colour is left aside. An
/// empty image if it is of another kind, or if its data are not as many as the pixels need.
cv::Mat decodePng(const PngHeader& header, const std::vector<unsigned char>& bytes);

}  // namespace xview::io
