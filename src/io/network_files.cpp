// SPDX-License-Identifier: BSD-3-Clause
#include "xview/io/network_files.h"

#include "image_decoding.h"
#include "xview/types/error.h"
#include "yaml_file.h"

namespace xview::io {
namespace {

std::array<double, 3> parseTriple(const YamlFile& file, const YAML::Node& node,
                                  const std::string& what) {
  if (!node.IsSequence() || node.size() != 3) file.fail(node, what + ": expected three numbers");
  std::array<double, 3> triple{};
  for (std::size_t i = 0; i < 3; ++i) triple[i] = file.number(node[i], what);
  return triple;
}

}  // namespace

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
  const cv::Mat image = decodeImage(path);
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
