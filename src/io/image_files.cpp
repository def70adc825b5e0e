// SPDX-License-Identifier: BSD-3-Clause
#include "xview/io/image_files.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "image_decoding.h"
#include "pfm_file.h"
#include "xview/io/atomic_file.h"
#include "xview/types/error.h"

namespace xview {
namespace {

bool endsWith(const std::string& path, const std::string& ending) {
  return path.size() >= ending.size() &&
         path.compare(path.size() - ending.size(), ending.size(), ending) == 0;
}

void dropImpossible(DepthImage& depth) {
  for (float& value : depth.pixels) {
    if (!std::isfinite(value) || value < 0) value = 0;
  }
}

DepthImage depthOfPixels(const cv::Mat& image, double depth_scale, const std::string& path) {
  if (image.channels() != 1 || (image.depth() != CV_16U && image.depth() != CV_32F)) {
    throw Error(path, "expected depth of 16-bit unsigned or 32-bit float, 1 channel, found " +
                          describePixels(image));
  }
  DepthImage depth(image.cols, image.rows);
  for (int y = 0; y < image.rows; ++y) {
    float* out = &depth.at(0, y);
    if (image.depth() == CV_32F) {
      std::copy_n(image.ptr<float>(y), image.cols, out);
    } else {
      const std::uint16_t* in = image.ptr<std::uint16_t>(y);
      for (int x = 0; x < image.cols; ++x) out[x] = static_cast<float>(in[x] * depth_scale);
    }
  }
  return depth;
}

void writePng(const std::string& path, const cv::Mat& image) {
  std::vector<unsigned char> bytes;
  if (image.empty()) throw Error(path, "an image without pixels cannot be written");
  if (!cv::imencode(".png", image, bytes)) throw Error(path, "cannot be encoded as PNG");
  AtomicFile file(path);
  file.write(bytes.data(), bytes.size());
  file.commit();
}

}  // namespace

DepthImage readDepth(const std::string& path, const Camera& camera) {
  const bool is_pfm = endsWith(path, ".pfm");
  const cv::Mat image = is_pfm ? cv::Mat() : decodeImage(path);
  DepthImage depth = is_pfm ? readPfm(path) : depthOfPixels(image, camera.depth_scale, path);
  if (is_pfm || image.depth() == CV_32F) dropImpossible(depth);
  if (depth.width != camera.width || depth.height != camera.height) {
    throw Error(path, "depth of " + std::to_string(depth.width) + " x " +
                          std::to_string(depth.height) + " pixels, the camera has " +
                          std::to_string(camera.width) + " x " + std::to_string(camera.height));
  }
  return depth;
}

LabelImage readLabels(const std::string& path) {
  const cv::Mat image = decodeImage(path);
  if (image.channels() != 1 || (image.depth() != CV_8U && image.depth() != CV_16U)) {
    throw Error(path, "expected class ids as 8 or 16-bit unsigned, 1 channel, found " +
                          describePixels(image));
  }
  return channelOf(image, 0, path);
}

void writeDepthPng(const std::string& path, const DepthImage& depth, double depth_scale) {
  cv::Mat image(depth.height, depth.width, CV_16U);
  for (int y = 0; y < depth.height; ++y) {
    std::uint16_t* out = image.ptr<std::uint16_t>(y);
    for (int x = 0; x < depth.width; ++x) {
      const double units = std::round(depth.at(x, y) / depth_scale);
      // Beyond the range of the image a measurement is as good as none.
      out[x] = units > 0 && units <= 65535 ? static_cast<std::uint16_t>(units) : 0;
    }
  }
  writePng(path, image);
}

void writeLabelPng(const std::string& path, const LabelImage& labels) {
  const auto largest = std::max_element(labels.pixels.begin(), labels.pixels.end());
  const bool narrow = largest == labels.pixels.end() || *largest < 256;
  cv::Mat image(labels.height, labels.width, narrow ? CV_8U : CV_16U);
  for (int y = 0; y < labels.height; ++y) {
    for (int x = 0; x < labels.width; ++x) {
      const std::uint16_t label = labels.at(x, y);
      if (narrow) {
        image.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(label);
      } else {
        image.at<std::uint16_t>(y, x) = label;
      }
    }
  }
  writePng(path, image);
}

}  // namespace xview
