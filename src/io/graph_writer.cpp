// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <charconv>
#include <cstdint>
#include <limits>

#include "class_comments.h"
#include "xview/io/atomic_file.h"
#include "xview/io/graph_files.h"

namespace xview {
namespace {

/// A line of numbers. Doubles get the fewest digits that read back as the same double, at most 17.
class NumberLine {
 public:
  template <class Number>
  NumberLine& operator<<(Number value) {
    char digits[32];
    const char* end = std::to_chars(digits, digits + sizeof(digits), value).ptr;
    if (!text_.empty()) text_ += ' ';
    text_.append(digits, static_cast<std::size_t>(end - digits));
    return *this;
  }
  std::string take() { return std::move(text_) + "\n"; }

 private:
  std::string text_;
};

std::string header(const SemanticGraph& graph, const LabelSet& labels) {
  // Most programs and people expect a signed label; the few ids beyond need the other type.
  const bool large =
      std::any_of(graph.vertices.begin(), graph.vertices.end(), [](const Vertex& vertex) {
        return vertex.label > static_cast<std::uint32_t>(std::numeric_limits<std::int32_t>::max());
      });
  return std::string("ply\nformat ascii 1.0\ncomment xview semantic graph 1, metres\n") +
         (graph.space == GraphSpace::image ? "comment graph_space image\n" : "") +
         classComments(labels, "comment ") + "element vertex " + std::to_string(graph.size()) +
         "\nproperty double x\nproperty double y\nproperty double z"
         "\nproperty uchar red\nproperty uchar green\nproperty uchar blue"
         "\nproperty " +
         (large ? "uint" : "int") +
         " label\nproperty uint instance"
         "\nproperty uint observations\nproperty uint points\nproperty double sigma"
         "\nproperty double extent_x\nproperty double extent_y\nproperty double extent_z"
         "\nproperty double first_frame\nproperty double last_frame"
         "\nelement edge " +
         std::to_string(graph.edgeCount()) +
         "\nproperty int vertex1\nproperty int vertex2\nend_header\n";
}

std::string vertexLine(const Vertex& vertex, const LabelSet& labels) {
  const auto [red, green, blue] = labels.color(vertex.label);
  NumberLine line;
  line << vertex.position.x() << vertex.position.y() << vertex.position.z() << red << green << blue
       << vertex.label << vertex.instance << vertex.observations << vertex.points << vertex.sigma_m
       << vertex.extent.x() << vertex.extent.y() << vertex.extent.z() << vertex.first_frame
       << vertex.last_frame;
  return line.take();
}

}  // namespace

void writeGraph(const std::string& path, const SemanticGraph& graph, const LabelSet& labels) {
  AtomicFile file(path);
  file.write(header(graph, labels));
  for (const Vertex& vertex : graph.vertices) file.write(vertexLine(vertex, labels));
  for (const auto& [a, b] : graph.edges()) {
    NumberLine line;
    line << a << b;
    file.write(line.take());
  }
  file.commit();
}

}  // namespace xview
