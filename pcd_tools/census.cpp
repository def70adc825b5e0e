// SPDX-License-Identifier: BSD-3-Clause
#include "census.h"

#include <fmt/core.h>

namespace xview::tools {

Census censusOf(const LabelledCloud& cloud) {
  Census census;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    ++census.counts[cloud.points[i].label];
    census.bounds.extend(cloud.position(i));
  }
  census.size = census.measured = cloud.size();
  return census;
}

Census censusOf(const SemanticGraph& graph) {
  Census census;
  for (const Vertex& vertex : graph.vertices) {
    ++census.counts[vertex.label];
    census.bounds.extend(vertex.position);
  }
  census.size = census.measured = graph.size();
  return census;
}

Census censusOf(const Frame& frame) {
  if (frame.sensor != Sensor::camera) return censusOf(frame.cloud);
  Census census;
  for (const std::uint16_t label : frame.label.pixels) ++census.counts[label];
  for (const float depth : frame.depth.pixels) census.measured += depth > 0;
  census.size = frame.depth.pixels.size();
  census.camera = fmt::format("{} x {} px, fx {:.1f}, fy {:.1f}, cx {:.1f}, cy {:.1f}",
                              frame.camera.width, frame.camera.height, frame.camera.fx,
                              frame.camera.fy, frame.camera.cx, frame.camera.cy);
  return census;
}

void printRow(const std::string& name, const std::string& value) {
  fmt::print("{:<14}{}\n", name, value);
}

void printBounds(const std::string& name, const Eigen::AlignedBox3d& box) {
  if (box.isEmpty()) return;
  const Eigen::Vector3d a = box.min(), b = box.max(), size = box.sizes();
  printRow(
      name,
      fmt::format(
          "x {:.2f} .. {:.2f}, y {:.2f} .. {:.2f}, z {:.2f} .. {:.2f} m ({:.1f} x {:.1f} x {:.1f})",
          a.x(), b.x(), a.y(), b.y(), a.z(), b.z(), size.x(), size.y(), size.z()));
}

void printClasses(const Census& census, const LabelSet& labels, const char* unit) {
  std::size_t total = 0;
  for (const auto& [id, count] : census.counts) total += count;
  printRow("classes", fmt::format("{}{}{}", census.counts.size(),
                                  labels.name().empty() ? "" : " of label set ", labels.name()));
  fmt::print("{:>6}  {:<24}{:<10}{:>14}\n", "id", "name", "role", unit);
  for (const auto& [id, count] : census.counts) {
    const char* role = labels.find(id) ? toString(labels.role(id)) : "unknown";
    fmt::print("{:>6}  {:<24}{:<10}{:>14}{:>7.2f} %\n", id, labels.className(id), role, count,
               100.0 * static_cast<double>(count) / static_cast<double>(total));
  }
}

}  // namespace xview::tools
