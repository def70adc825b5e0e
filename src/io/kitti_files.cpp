// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <limits>
#include <new>

#include "input_file.h"
#include "xview/io/cloud_files.h"

namespace xview {
namespace {

constexpr std::size_t kPointBytes = 4 * sizeof(float);
constexpr std::size_t kLabelBytes = sizeof(std::uint32_t);

std::size_t pointCount(const InputFile& scan) {
  const std::uint64_t points = scan.size() / kPointBytes;
  if (scan.size() % kPointBytes != 0) {
    scan.fail("expected 16 bytes per point (x y z intensity), found " +
              std::to_string(scan.size()) + " bytes: " + std::to_string(scan.size() % kPointBytes) +
              " are left after " + std::to_string(points) + " points");
  }
  if (points > std::numeric_limits<std::int32_t>::max()) scan.fail("has more than 2^31 points");
  return static_cast<std::size_t>(points);
}

void requireLabels(const InputFile& labels, const InputFile& scan, std::size_t points) {
  if (labels.size() == points * kLabelBytes) return;
  labels.fail("expected " + std::to_string(points) + " labels of 4 bytes, one for each point of " +
              scan.path() + ", found " + std::to_string(labels.size()) + " bytes");
}

LabelledCloud readScan(InputFile& scan, InputFile& labels, std::size_t points) {
  LabelledCloud cloud;
  cloud.points.reserve(points);
  for (std::size_t i = 0; i < points; ++i) {
    float position[4];
    std::uint32_t label = 0;
    scan.readBytes(position, sizeof(position));
    labels.readBytes(&label, sizeof(label));
    if (!Eigen::Map<const Eigen::Vector3f>(position).allFinite()) continue;
    Point point;
    point.getVector3fMap() = Eigen::Map<const Eigen::Vector3f>(position);
    point.label = label & 0xFFFF;
    point.instance = label >> 16;
    cloud.points.push_back(point);
  }
  return cloud;
}

}  // namespace

LabelledCloud readKittiScan(const std::string& bin_path, const std::string& label_path) {
  InputFile scan(bin_path), labels(label_path);
  const std::size_t points = pointCount(scan);
  requireLabels(labels, scan, points);
  try {
    return readScan(scan, labels, points);
  } catch (const std::bad_alloc&) {
    scan.fail("needs more memory than there is for its " + std::to_string(points) + " points");
  }
}

}  // namespace xview
