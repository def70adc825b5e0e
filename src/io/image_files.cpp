// SPDX-License-Identifier: BSD-3-Clause
#include "io/image_files.h"

#include <fmt/core.h>
#include <libdeflate.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <new>
#include <opencv2/core/mat.hpp>
#include <string_view>

#include "image_decoding.h"
#include "process/atomic_file.h"
#include "xview/base/error.h"
#include "yaml_file.h"

namespace xview::io {
namespace {

void dropImpossible(DepthImage& depth) {
  for (float& value : depth.pixels) {
    if (!std::isfinite(value) || value < 0) value = 0;
  }
}

// ---- PNG

void appendBigEndian(std::uint32_t value, std::string& bytes) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift);
}

void appendChunk(const std::string& type, std::string_view data, std::string& png) {
  appendBigEndian(static_cast<std::uint32_t>(data.size()), png);
  const std::size_t begin = png.size();
  png.append(type).append(data);
  appendBigEndian(libdeflate_crc32(0, &png[begin], png.size() - begin), png);
}

/// The samples of a row as they stand in the file, each as the difference to the one on its left
/// (filter 1 of section 9), which packs better.
template <class Sample>
void appendRow(const Sample* row, int width, std::string& rows) {
  rows += 1;
  Sample left = 0;
  for (int x = 0; x < width; ++x) {
    for (int shift = 8 * (sizeof(Sample) - 1); shift >= 0; shift -= 8)
      rows += static_cast<char>((row[x] >> shift) - (left >> shift));
    left = row[x];
  }
}

std::string packed(const std::string& bytes) {
  constexpr int kFast = 1;
  const std::unique_ptr<libdeflate_compressor, void (*)(libdeflate_compressor*)> packer(
      libdeflate_alloc_compressor(kFast), libdeflate_free_compressor);
  if (!packer) throw std::bad_alloc();
  std::string out(libdeflate_zlib_compress_bound(packer.get(), bytes.size()), 0);
  out.resize(
      libdeflate_zlib_compress(packer.get(), bytes.data(), bytes.size(), out.data(), out.size()));
  return out;
}

/// Grey, of 8 or 16 bits as the samples are.
template <class Sample>
void writePng(const std::string& path, const Image<Sample>& image) {
  if (image.empty()) throw Error(path, "an image without pixels cannot be written");
  std::string header, rows, png = "\x89PNG\r\n\x1A\n";
  appendBigEndian(static_cast<std::uint32_t>(image.width), header);
  appendBigEndian(static_cast<std::uint32_t>(image.height), header);
  header += {8 * sizeof(Sample), 0, 0, 0, 0};
  for (int y = 0; y < image.height; ++y) appendRow(&image.at(0, y), image.width, rows);
  appendChunk("IHDR", header, png);
  appendChunk("IDAT", packed(rows), png);
  appendChunk("IEND", {}, png);
  writeFile(path, png);
}

// ---- camera.yaml

constexpr int kMaxCameraSide = 32768;

void requireAll(const std::string& path, const YAML::Node& root,
                const std::vector<std::string>& required) {
  std::string missing;
  for (const std::string& key : required) {
    if (!root[key]) missing += (missing.empty() ? "" : ", ") + key;
  }
  if (!missing.empty()) throw Error(path, "missing: " + missing);
}

double positive(const YamlFile& file, const std::string& key) {
  const double value = file.number(file.root()[key], key);
  if (value <= 0) file.fail(file.root()[key], key + ": expected a number above 0");
  return value;
}

std::array<double, 3> parseTriple(const YamlFile& file, const YAML::Node& node,
                                  const std::string& what) {
  if (!node.IsSequence() || node.size() != 3) file.fail(node, what + ": expected three numbers");
  std::array<double, 3> triple{};
  for (std::size_t i = 0; i < 3; ++i) triple[i] = file.number(node[i], what);
  return triple;
}

}  // namespace

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
  if (image.depth() == CV_32F) dropImpossible(depth);
  return depth;
}

DepthImage readDepth(const std::string& path, const Camera& camera) {
  const SizeCheck check = [&](std::int64_t width, std::int64_t height) {
    if (width == camera.width && height == camera.height) return;
    throw Error(path, fmt::format("depth of {} x {} pixels, the camera has {} x {}", width, height,
                                  camera.width, camera.height));
  };
  const bool is_pfm = std::filesystem::path(path).extension() == ".pfm";
  const cv::Mat image = is_pfm ? cv::Mat() : decodeImage(path, check);
  DepthImage depth = is_pfm ? readPfm(path) : depthOfPixels(image, camera.depth_scale, path);
  if (is_pfm) dropImpossible(depth);
  check(depth.width, depth.height);
  return depth;
}

LabelImage readLabels(const std::string& path, const SizeCheck& check) {
  const cv::Mat image = decodeImage(path, check);
  if (image.channels() != 1 || (image.depth() != CV_8U && image.depth() != CV_16U)) {
    throw Error(path, "expected class ids as 8 or 16-bit unsigned, 1 channel, found " +
                          describePixels(image));
  }
  return channelOf(image, 0, path);
}

LabelImage readLabels(const std::string& path) { return readLabels(path, anySize(path)); }

void writeDepthPng(const std::string& path, const DepthImage& depth, double depth_scale) {
  Image<std::uint16_t> image(depth.width, depth.height);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    const double units = std::round(depth.pixels[i] / depth_scale);
    // Beyond the range of the image a measurement is as good as none.
    if (units > 0 && units <= 65535) image.pixels[i] = static_cast<std::uint16_t>(units);
  }
  writePng(path, image);
}

void writeLabelPng(const std::string& path, const LabelImage& labels) {
  const auto largest = std::max_element(labels.pixels.begin(), labels.pixels.end());
  if (largest != labels.pixels.end() && *largest > 255) return writePng(path, labels);
  Image<std::uint8_t> narrow(labels.width, labels.height);
  std::transform(labels.pixels.begin(), labels.pixels.end(), narrow.pixels.begin(),
                 [](std::uint16_t id) { return static_cast<std::uint8_t>(id); });
  writePng(path, narrow);
}

Camera readCamera(const std::string& path) {
  const std::vector<std::string> required = {"width", "height", "fx",         "fy",
                                             "cx",    "cy",     "depth_scale"};
  std::vector<std::string> known = required;
  known.insert(known.end(), {"depth", "sensor", "min_range", "max_range"});
  const YamlFile file = YamlFile::read(path);
  const YAML::Node root = file.root();
  if (root.IsNull()) throw Error(path, "the file is empty, expected width, height, fx, …");
  file.requireKeys(root, known);
  requireAll(path, root, required);

  Camera camera;
  camera.width = static_cast<int>(file.integer(root["width"], "width", 1, kMaxCameraSide));
  camera.height = static_cast<int>(file.integer(root["height"], "height", 1, kMaxCameraSide));
  camera.fx = positive(file, "fx");
  camera.fy = positive(file, "fy");
  camera.cx = file.number(root["cx"], "cx");
  camera.cy = file.number(root["cy"], "cy");
  camera.depth_scale = positive(file, "depth_scale");
  if (root["depth"]) {
    const std::string depth = file.text(root["depth"], "depth");
    if (depth != "range" && depth != "planar") {
      file.fail(root["depth"], "depth: expected range or planar, found '" + depth + "'");
    }
    camera.depth_is_range = depth == "range";
  }
  if (root["min_range"]) camera.min_range_m = file.number(root["min_range"], "min_range");
  if (root["max_range"]) camera.max_range_m = positive(file, "max_range");
  if (!(camera.min_range_m >= 0 && camera.min_range_m < camera.max_range_m)) {
    file.fail(root["min_range"], "min_range: expected 0 <= min_range < max_range");
  }
  return camera;
}

void writeCamera(const std::string& path, const Camera& camera) {
  std::string text = fmt::format(
      "width: {}\nheight: {}\nfx: {:.17g}\nfy: {:.17g}\ncx: {:.17g}\ncy: {:.17g}\n"
      "depth_scale: {:.17g}\ndepth: {}\n",
      camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy, camera.depth_scale,
      camera.depth_is_range ? "range" : "planar");
  if (camera.min_range_m > 0) text += fmt::format("min_range: {:.17g}\n", camera.min_range_m);
  if (std::isfinite(camera.max_range_m))
    text += fmt::format("max_range: {:.17g}\n", camera.max_range_m);
  writeFile(path, text);
}

NetworkInput readNetworkInput(const std::string& path) {
  constexpr std::int64_t kLargest_px = 1 << 14, kLargestId = 0xFFFF;
  const YamlFile file = YamlFile::read(path);
  const YAML::Node root = file.root();
  file.requireKeys(root, {"labels", "ids", "width", "height", "mean", "std", "order"});
  if (!root["labels"]) file.fail(root, "labels: missing, expected a label set or a classes.yaml");
  NetworkInput input;
  input.labels = file.text(root["labels"], "labels");
  for (const YAML::Node& id : root["ids"])
    input.ids.push_back(static_cast<std::uint32_t>(file.integer(id, "ids", 0, kLargestId)));
  if (root["width"])
    input.width = static_cast<int>(file.integer(root["width"], "width", 1, kLargest_px));
  if (root["height"])
    input.height = static_cast<int>(file.integer(root["height"], "height", 1, kLargest_px));
  if (root["mean"]) input.mean = parseTriple(file, root["mean"], "mean");
  if (root["std"]) input.std = parseTriple(file, root["std"], "std");
  for (const double s : input.std) {
    if (!(s > 0)) file.fail(root["std"], "std: must be > 0");
  }
  if (root["order"]) {
    const std::string order = file.text(root["order"], "order");
    if (order != "rgb" && order != "bgr") file.fail(root["order"], "order: expected rgb or bgr");
    input.is_rgb = order == "rgb";
  }
  return input;
}

ColorImage readColors(const std::string& path) {
  const cv::Mat image = decodeImage(path, anySize(path));
  if (image.depth() != CV_8U)
    throw Error(path, "expected colours of 8 bits, found " + describePixels(image));
  const int channels = image.channels();
  ColorImage colors(image.cols, image.rows);
  for (int y = 0; y < image.rows; ++y) {
    const std::uint8_t* pixel = image.ptr<std::uint8_t>(y);  // blue, green, red
    for (int x = 0; x < image.cols; ++x, pixel += channels) {
      if (channels < 3)
        colors.at(x, y) = {pixel[0], pixel[0], pixel[0]};
      else
        colors.at(x, y) = {pixel[2], pixel[1], pixel[0]};
    }
  }
  return colors;
}

}  // namespace xview::io
