// SPDX-License-Identifier: BSD-3-Clause
#include "io/graph_files.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <new>

#include "point_table.h"
#include "process/atomic_file.h"

namespace xview::io {
namespace {

using Edges = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// The columns of the vertices that are there, by name.
class VertexColumns {
 public:
  VertexColumns(const Element& vertices, const InputFile& file) : columns_(vertices, file) {
    const IdColumns ids = findIdColumns(vertices, {}, file);
    if (!ids.label) file.fail("has no label field; its fields: " + vertices.columnNames());
    label_ = columns_.add(ids.label);
    instance_ = columns_.add(ids.instance);
    const auto add = [&](const char* name) {
      return columns_.add(vertices.findColumn(name, file));
    };
    extent_[0] = add("extent_x");
    extent_[1] = add("extent_y");
    extent_[2] = add("extent_z");
    sigma_ = add("sigma");
    observations_ = add("observations");
    points_ = add("points");
    first_frame_ = add("first_frame");
    last_frame_ = add("last_frame");
  }

  const std::vector<std::size_t>& chosen() const { return columns_.all(); }

  Vertex vertex(const double* values, const RowPlace& place) const {
    Vertex vertex;
    vertex.position = {values[0], values[1], values[2]};
    constexpr double kFarthest_m = 1e12;  // single precision has no room for the largest doubles
    if (!vertex.position.allFinite()) place.fail("the position is not finite");
    if (vertex.position.cwiseAbs().maxCoeff() > kFarthest_m)
      place.fail("a coordinate beyond 1e12 m");
    vertex.label = columns_.id(label_, values, place);
    vertex.instance = columns_.id(instance_, values, place);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      vertex.extent[static_cast<Eigen::Index>(axis)] = length(extent_[axis], values, place);
    }
    vertex.sigma_m = length(sigma_, values, place);
    vertex.observations = columns_.id(observations_, values, place, 1);
    vertex.points = columns_.id(points_, values, place);
    vertex.first_frame = frame(first_frame_, values, place);
    vertex.last_frame = frame(last_frame_, values, place);
    return vertex;
  }

 private:
  using Slot = ChosenColumns::Slot;

  double length(const Slot& slot, const double* values, const RowPlace& place) const {
    if (!slot) return 0;
    const double value = values[*slot];
    if (!(std::isfinite(value) && value >= 0))
      place.fail("{} must be finite and >= 0", inQuotes(columns_.column(*slot).name));
    return value;
  }

  std::int64_t frame(const Slot& slot, const double* values, const RowPlace& place) const {
    if (!slot) return 0;
    const double value = values[*slot];
    if (!(std::abs(value) <= 0x1p53 && value == std::floor(value))) {
      place.fail("{} must be a whole number", inQuotes(columns_.column(*slot).name));
    }
    return static_cast<std::int64_t>(value);
  }

  ChosenColumns columns_;
  Slot label_, instance_, extent_[3], sigma_, observations_, points_, first_frame_, last_frame_;
};

std::vector<Vertex> readVertices(InputFile& file, const FileLayout& layout,
                                 const Element& element) {
  const VertexColumns columns(element, file);
  std::vector<Vertex> vertices;
  readRows(file, layout, element, columns.chosen(),
           [&](const double* values, const RowPlace& place) {
             vertices.push_back(columns.vertex(values, place));
           });
  return vertices;
}

Edges readEdges(InputFile& file, const FileLayout& layout, const Element& element,
                std::uint64_t vertices) {
  std::vector<std::size_t> columns;
  for (const char* name : {"vertex1", "vertex2"}) {
    const auto column = element.findColumn(name, file);
    if (!column) file.fail("the element edge has no property {}", name);
    columns.push_back(*column);
  }
  Edges edges;
  readRows(file, layout, element, columns, [&](const double* ends, const RowPlace& place) {
    for (int end = 0; end < 2; ++end) {
      if (ends[end] >= 0 && ends[end] < static_cast<double>(vertices) &&
          ends[end] == std::floor(ends[end]))
        continue;
      place.fail("an edge must join vertices 0 to {} (excluded)", vertices);
    }
    edges.emplace_back(static_cast<std::uint32_t>(ends[0]), static_cast<std::uint32_t>(ends[1]));
  });
  return edges;
}

bool contains(const std::vector<std::string>& lines, const std::string& line) {
  return std::find(lines.begin(), lines.end(), line) != lines.end();
}

GraphFile readElements(InputFile& file, const FileLayout& layout) {
  const Element* vertices = layout.findElement("vertex");
  if (!vertices) file.fail("has no element vertex");
  if (vertices->rows > std::numeric_limits<std::int32_t>::max())
    file.fail("has more than 2^31 vertices");
  GraphFile result;
  Edges edges;
  for (const Element& element : layout.elements) {
    if (&element == vertices) {
      result.graph.vertices = readVertices(file, layout, element);
    } else if (element.name == "edge") {
      result.has_edges = true;
      edges = readEdges(file, layout, element, vertices->rows);
    } else {
      readRows(file, layout, element, {}, nullptr);
    }
  }
  requireEnd(file, layout);
  result.graph.setEdges(edges);
  if (result.has_edges && contains(layout.comments, "graph_space image")) {
    result.graph.space = GraphSpace::image;
  }
  result.labels = readClassComments(layout.comments, file);
  return result;
}

// ---- writing

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
  return fmt::format(
      "ply\nformat ascii 1.0\ncomment xview semantic graph 1, metres\n{}{}element vertex {}\n"
      "property double x\nproperty double y\nproperty double z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\n"
      "property {} label\nproperty uint instance\n"
      "property uint observations\nproperty uint points\nproperty double sigma\n"
      "property double extent_x\nproperty double extent_y\nproperty double extent_z\n"
      "property double first_frame\nproperty double last_frame\n"
      "element edge {}\nproperty int vertex1\nproperty int vertex2\nend_header\n",
      graph.space == GraphSpace::image ? "comment graph_space image\n" : "",
      classComments(labels, "comment "), graph.size(), large ? "uint" : "int", graph.edgeCount());
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

GraphFile readGraph(const std::string& path) {
  InputFile file(path);
  try {
    const FileLayout layout = readPlyHeader(file);
    checkSize(file, layout);
    return readElements(file, layout);
  } catch (const std::bad_alloc&) {
    file.fail("needs more memory than there is for its {} bytes", file.size());
  }
}

void writeGraph(const std::string& path, const SemanticGraph& graph, const LabelSet& labels) {
  const std::string beginning = header(graph, labels);
  requireReadable(path, beginning);
  AtomicFile file(path);
  file.write(beginning);
  for (const Vertex& vertex : graph.vertices) file.write(vertexLine(vertex, labels));
  for (const auto& [a, b] : graph.edges()) {
    NumberLine line;
    line << a << b;
    file.write(line.take());
  }
  file.commit();
}

}  // namespace xview::io
