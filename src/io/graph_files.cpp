// SPDX-License-Identifier: BSD-3-Clause
#include "xview/io/graph_files.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>

#include "class_comments.h"
#include "cloud_columns.h"
#include "id_value.h"
#include "ply_header.h"
#include "row_reader.h"

namespace xview {
namespace {

using Edges = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// The columns of the vertices that are there, by name.
class VertexColumns {
 public:
  VertexColumns(const Element& vertices, const InputFile& file) : element_(vertices) {
    columns_ = positionColumns(vertices, file);
    const IdColumns ids = findIdColumns(vertices, {}, file);
    if (!ids.label) file.fail("has no label field; its fields: " + vertices.columnNames());
    label_ = add(ids.label);
    instance_ = add(ids.instance);
    const char* const axes[] = {"extent_x", "extent_y", "extent_z"};
    for (std::size_t axis = 0; axis < 3; ++axis)
      extent_[axis] = add(findScalarColumn(vertices, axes[axis], file));
    sigma_ = add(findScalarColumn(vertices, "sigma", file));
    observations_ = add(findScalarColumn(vertices, "observations", file));
    points_ = add(findScalarColumn(vertices, "points", file));
    first_frame_ = add(findScalarColumn(vertices, "first_frame", file));
    last_frame_ = add(findScalarColumn(vertices, "last_frame", file));
  }

  const std::vector<std::size_t>& chosen() const { return columns_; }

  Vertex vertex(const double* values, const RowPlace& place) const {
    Vertex vertex;
    vertex.position = {values[0], values[1], values[2]};
    if (!vertex.position.allFinite()) place.fail("the position is not finite");
    vertex.label = id(label_, values, place, 0);
    vertex.instance = id(instance_, values, place, 0);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      vertex.extent[static_cast<Eigen::Index>(axis)] = length(extent_[axis], values, place);
    }
    vertex.sigma_m = length(sigma_, values, place);
    vertex.observations = id(observations_, values, place, 1);
    vertex.points = id(points_, values, place, 0);
    vertex.first_frame = frame(first_frame_, values, place);
    vertex.last_frame = frame(last_frame_, values, place);
    return vertex;
  }

 private:
  using Slot = std::optional<std::size_t>;  ///< among the chosen columns

  Slot add(const std::optional<std::size_t>& column) {
    if (!column) return std::nullopt;
    columns_.push_back(*column);
    return columns_.size() - 1;
  }

  const Column& column(std::size_t slot) const { return element_.columns[columns_[slot]]; }

  std::uint32_t id(const Slot& slot, const double* values, const RowPlace& place,
                   std::uint32_t absent) const {
    return slot ? idFromNumber(values[*slot], column(*slot), place) : absent;
  }

  double length(const Slot& slot, const double* values, const RowPlace& place) const {
    if (!slot) return 0;
    const double value = values[*slot];
    if (!(std::isfinite(value) && value >= 0))
      place.fail(quoted(column(*slot).name) + " must be finite and >= 0");
    return value;
  }

  std::int64_t frame(const Slot& slot, const double* values, const RowPlace& place) const {
    if (!slot) return 0;
    const double value = values[*slot];
    if (!(std::abs(value) <= 0x1p53 && value == std::floor(value))) {
      place.fail(quoted(column(*slot).name) + " must be a whole number");
    }
    return static_cast<std::int64_t>(value);
  }

  const Element& element_;
  std::vector<std::size_t> columns_;
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
    const auto column = findScalarColumn(element, name, file);
    if (!column) file.fail(std::string("the element edge has no property ") + name);
    columns.push_back(*column);
  }
  Edges edges;
  readRows(file, layout, element, columns, [&](const double* ends, const RowPlace& place) {
    for (int end = 0; end < 2; ++end) {
      if (ends[end] >= 0 && ends[end] < static_cast<double>(vertices) &&
          ends[end] == std::floor(ends[end]))
        continue;
      place.fail("an edge must join vertices 0 to " + std::to_string(vertices) + " (excluded)");
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

}  // namespace

GraphFile readGraph(const std::string& path) {
  InputFile file(path);
  try {
    const FileLayout layout = readPlyHeader(file);
    checkSize(file, layout);
    return readElements(file, layout);
  } catch (const std::bad_alloc&) {
    file.fail("needs more memory than there is for its " + std::to_string(file.size()) + " bytes");
  }
}

}  // namespace xview
