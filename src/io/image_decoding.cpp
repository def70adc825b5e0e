// SPDX-License-Identifier: BSD-3-Clause
#include "image_decoding.h"

#include <cstdlib>
#include <cstring>
#include <mutex>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "input_file.h"
#include "png_header.h"
#include "png_pixels.h"
#include "xview/types/error.h"

namespace xview {
namespace {

/// OpenCV refuses EXR unless this is in the environment before it looks for the first time.
void allowExr() {
  static std::once_flag once;
  std::call_once(once, [] { setenv("OPENCV_IO_ENABLE_OPENEXR", "1", 0); });
}

/// By its ending or its first bytes, whichever says so.
bool isPng(const std::string& path, const std::vector<unsigned char>& bytes) {
  const bool named = path.size() >= 4 && (path.compare(path.size() - 4, 4, ".png") == 0 ||
                                          path.compare(path.size() - 4, 4, ".PNG") == 0);
  return named || (bytes.size() >= 4 && std::memcmp(bytes.data(), "\x89PNG", 4) == 0);
}

/// Empty if OpenCV has to try.
cv::Mat decodeSoundPng(const std::string& path, const std::vector<unsigned char>& bytes) {
  const PngHeader header = checkPng(path, bytes);
  if (header.color == PngColor::palette || header.bits < 8) {
    throw Error(path,
                "expected 8 or 16 bits per channel without a palette, found " + describe(header));
  }
  return decodePng(header, bytes);
}

}  // namespace

cv::Mat decodeImage(const std::string& path) {
  InputFile file(path);
  if (file.size() == 0) throw Error(path, "the file is empty, expected an image");
  std::vector<unsigned char> bytes(file.size());
  file.readBytes(bytes.data(), bytes.size());
  cv::Mat image;
  if (isPng(path, bytes)) image = decodeSoundPng(path, bytes);
  if (!image.empty()) return image;
  allowExr();
  try {
    image = cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception& problem) {
    throw Error(path, "cannot be decoded: " + problem.err);
  }
  if (image.empty()) throw Error(path, "cannot be decoded as an image; is it damaged?");
  return image;
}

std::string describePixels(const cv::Mat& image) {
  static constexpr const char* kTypes[] = {"8-bit unsigned", "8-bit signed",  "16-bit unsigned",
                                           "16-bit signed",  "32-bit signed", "32-bit float",
                                           "64-bit float",   "16-bit float"};
  const int channels = image.channels();
  return std::string(kTypes[image.depth()]) + ", " + std::to_string(channels) +
         (channels == 1 ? " channel" : " channels");
}

LabelImage channelOf(const cv::Mat& image, int channel, const std::string& path) {
  const bool fits = image.depth() == CV_8U || image.depth() == CV_16U;
  if (!fits || channel >= image.channels()) {
    throw Error(path, "expected 8 or 16-bit unsigned with at least " + std::to_string(channel + 1) +
                          " channels, found " + describePixels(image));
  }
  LabelImage result(image.cols, image.rows);
  const int channels = image.channels();
  for (int y = 0; y < image.rows; ++y) {
    std::uint16_t* out = &result.at(0, y);
    if (image.depth() == CV_8U) {
      const std::uint8_t* in = image.ptr<std::uint8_t>(y) + channel;
      for (int x = 0; x < image.cols; ++x) out[x] = in[x * channels];
    } else {
      const std::uint16_t* in = image.ptr<std::uint16_t>(y) + channel;
      for (int x = 0; x < image.cols; ++x) out[x] = in[x * channels];
    }
  }
  return result;
}

}  // namespace xview
