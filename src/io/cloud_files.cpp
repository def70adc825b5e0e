// SPDX-License-Identifier: BSD-3-Clause
#include "xview/io/cloud_files.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <new>

#include "class_comments.h"
#include "cloud_builder.h"
#include "cloud_columns.h"
#include "id_value.h"
#include "pcd_header.h"
#include "ply_header.h"
#include "row_reader.h"
#include "xview/types/error.h"

namespace xview {
namespace {

bool endsWith(const std::string& path, const std::string& ending) {
  return path.size() >= ending.size() &&
         std::equal(
             ending.begin(), ending.end(), path.end() - static_cast<std::ptrdiff_t>(ending.size()),
             [](char a, char b) { return a == std::tolower(static_cast<unsigned char>(b)); });
}

FileLayout readLayout(InputFile& file) {
  if (!endsWith(file.path(), ".ply") && !endsWith(file.path(), ".pcd")) {
    file.fail("expected a file that ends in .pcd or .ply");
  }
  FileLayout layout = endsWith(file.path(), ".ply") ? readPlyHeader(file) : readPcdHeader(file);
  checkSize(file, layout);
  return layout;
}

const Element& pointsOf(const FileLayout& layout, const InputFile& file) {
  if (const Element* points = layout.findElement("point")) return *points;
  if (const Element* vertices = layout.findElement("vertex")) return *vertices;
  file.fail("has no element vertex");
}

bool looksLikeGraph(const FileLayout& layout, const Element& points) {
  const auto isOurs = [](const Column& column) {
    return column.name == "observations" || column.name == "sigma" || column.name == "extent_x";
  };
  return layout.findElement("edge") != nullptr ||
         std::any_of(points.columns.begin(), points.columns.end(), isOurs);
}

/// Coordinates farther than this are stored relative to an origin. Numbers that are float32 in the
/// file lose nothing in a float32 cloud; a text may have more digits than the type its header
/// declares.
double farLimit(const FileLayout& layout, const Element& points,
                const std::vector<std::size_t>& columns) {
  constexpr double kDoubleFar_m = 1e3, kTextFar_m = 1e4;
  for (int axis = 0; axis < 3; ++axis) {
    if (points.columns[columns[static_cast<std::size_t>(axis)]].type != ScalarType::f32)
      return kDoubleFar_m;
  }
  return layout.encoding == Encoding::ascii ? kTextFar_m : CloudBuilder::kNever;
}

/// How many points to make room for once the first row is there. Binary files are known to hold
/// what their header announces; a text holds no more than its length allows.
std::size_t likelyPoints(const InputFile& file, const FileLayout& layout, const Element& points) {
  const std::uint64_t text_row_bytes = 2 * points.columns.size();
  const std::uint64_t most =
      layout.encoding == Encoding::ascii ? 2 + file.remaining() / text_row_bytes : points.rows;
  return static_cast<std::size_t>(std::min(points.rows, most));
}

LabelledCloud readPoints(InputFile& file, const FileLayout& layout, const Element& points,
                         const IdColumns& ids, std::vector<std::uint16_t>* rings) {
  constexpr std::uint64_t kMostPoints =
      std::numeric_limits<std::int32_t>::max();  // PCL counts in int
  if (points.rows > kMostPoints) file.fail("has more than 2^31 points");

  std::vector<std::size_t> columns = positionColumns(points, file);
  CloudBuilder builder(farLimit(layout, points, columns));
  if (ids.label) columns.push_back(*ids.label);
  if (ids.instance) columns.push_back(*ids.instance);
  if (ids.ring) columns.push_back(*ids.ring);
  const std::size_t instance_slot = ids.label ? 4 : 3;
  const std::size_t ring_slot = columns.size() - 1;

  readRows(file, layout, points, columns, [&](const double* values, const RowPlace& place) {
    if (place.row == 0) builder.reserve(likelyPoints(file, layout, points));
    const Eigen::Vector3d position(values[0], values[1], values[2]);
    if (!position.allFinite()) return;  // a pixel without measurement; its label means nothing
    const auto id = [&](std::size_t slot) {
      return idFromNumber(values[slot], points.columns[columns[slot]], place);
    };
    builder.add(position, ids.label ? id(3) : 0, ids.instance ? id(instance_slot) : 0, place);
    if (ids.ring) builder.addRing(values[ring_slot]);
  });
  if (rings) *rings = builder.rings();
  return builder.finish();
}

LabelledCloud readElements(InputFile& file, const FileLayout& layout, const IdColumns& ids,
                           std::vector<std::uint16_t>* rings) {
  const Element& points = pointsOf(layout, file);
  LabelledCloud cloud;
  for (const Element& element : layout.elements) {
    if (&element == &points) {
      cloud = readPoints(file, layout, points, ids, rings);
    } else {
      readRows(file, layout, element, {}, nullptr);
    }
  }
  requireEnd(file, layout);
  return cloud;
}

}  // namespace

CloudHeader readCloudHeader(const std::string& path, const CloudFields& fields) {
  InputFile file(path);
  const FileLayout layout = readLayout(file);
  const Element& points = pointsOf(layout, file);
  CloudHeader header;
  header.format = layout.format;
  header.points = static_cast<std::size_t>(points.rows);
  for (const Column& column : points.columns) header.fields.push_back(column.name);
  const IdColumns ids = findIdColumns(points, fields, file);
  if (ids.label) header.label_field = points.columns[*ids.label].name;
  if (ids.instance) header.instance_field = points.columns[*ids.instance].name;
  header.has_edges = looksLikeGraph(layout, points);
  header.labels = readClassComments(layout.comments, file);
  return header;
}

LabelledCloud readCloud(const std::string& path, const CloudFields& fields, bool require_label,
                        std::vector<std::uint16_t>* rings) {
  InputFile file(path);
  try {
    const FileLayout layout = readLayout(file);
    const Element& points = pointsOf(layout, file);
    const IdColumns ids = findIdColumns(points, fields, file);
    if (require_label && !ids.label) {
      file.fail("has no label field, name one with --label-field; its fields: " +
                points.columnNames());
    }
    return readElements(file, layout, ids, rings);
  } catch (const std::bad_alloc&) {
    file.fail("needs more memory than there is for its " + std::to_string(file.size()) + " bytes");
  }
}

}  // namespace xview
