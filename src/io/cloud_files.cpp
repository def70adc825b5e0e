// SPDX-License-Identifier: BSD-3-Clause
#include "xview/io/cloud_files.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <new>

#include "base/median.h"
#include "base/stray_points.h"
#include "cloud_tiles.h"
#include "point_table.h"
#include "process/atomic_file.h"

namespace xview::io {
namespace {

struct CloudFormat {
  const char* ending;
  FileLayout (*readHeader)(InputFile& file);
};
/// Every kind of cloud by the ending of its files, and who reads its header.
constexpr CloudFormat kCloudFormats[] = {{".pcd", readPcdHeader},
                                         {".ply", readPlyHeader},
                                         {".las", readLasHeader},
                                         {".e57", readE57Header}};

const CloudFormat* cloudFormatOf(const std::string& path) {
  const std::string ending = endingOf(path);
  const auto found =
      std::find_if(std::begin(kCloudFormats), std::end(kCloudFormats),
                   [&](const CloudFormat& format) { return format.ending == ending; });
  return found == std::end(kCloudFormats) ? nullptr : found;
}

}  // namespace

FileLayout readCloudLayout(InputFile& file) {
  const CloudFormat* format = cloudFormatOf(file.path());
  if (!format) file.fail("expected a file that ends in {}", fmt::join(cloudEndings(), ", "));
  FileLayout layout = format->readHeader(file);
  checkSize(file, layout);
  return layout;
}

const Element& pointsIn(const FileLayout& layout, const InputFile& file) {
  if (const Element* points = layout.findElement("point")) return *points;
  if (const Element* vertices = layout.findElement("vertex")) return *vertices;
  file.fail("has no element vertex");
}

namespace {

/// Coordinates farther than this are stored relative to an origin. Numbers that are float32 in the
/// file lose nothing in a float32 cloud; a text may have more digits than the type its header
/// declares.
double farLimit(const FileLayout& layout, const ChosenColumns& columns) {
  constexpr double kDoubleFar_m = 1e3, kTextFar_m = 1e4;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (columns.column(axis).type != ScalarType::f32) return kDoubleFar_m;
  }
  return layout.encoding == Encoding::ascii ? kTextFar_m : std::numeric_limits<double>::infinity();
}

/// How many points to make room for once the first row is there. Binary files are known to hold
/// what their header announces; a text holds no more than its length allows.
std::size_t likelyPoints(const InputFile& file, const FileLayout& layout, const Element& points) {
  const std::uint64_t text_row_bytes = 2 * points.columns.size();
  const std::uint64_t most =
      layout.encoding == Encoding::ascii ? 2 + file.remaining() / text_row_bytes : points.rows;
  return static_cast<std::size_t>(std::min(points.rows, most));
}

/// Visits the chosen columns of all rows.
using ReadColumns =
    std::function<void(const std::vector<std::size_t>& columns, const RowVisitor& visit)>;

LabelledCloud readPoints(const InputFile& file, const FileLayout& layout, const Element& points,
                         const IdColumns& ids, const ReadColumns& read) {
  constexpr std::uint64_t kMostPoints =
      std::numeric_limits<std::int32_t>::max();  // PCL counts in int
  if (points.rows > kMostPoints) file.fail("has more than 2^31 points");

  ChosenColumns columns(points, file);
  const auto label = columns.add(ids.label), instance = columns.add(ids.instance),
             sigma = columns.add(findSigmaColumn(points, file));
  const bool has_flags = ids.label && points.columns[*ids.label].name == "classification";
  const std::uint32_t label_bits = has_flags ? layout.label_bits : ~std::uint32_t{0};
  CloudBuilder builder(farLimit(layout, columns));
  std::size_t no_class = 0;
  read(columns.all(), [&](const double* values, const RowPlace& place) {
    if (place.row == 0) builder.reserve(likelyPoints(file, layout, points));
    const Eigen::Vector3d position =
        Eigen::Array3d(values[0], values[1], values[2]) * layout.scale + layout.offset;
    if (!position.allFinite()) return;  // a pixel without measurement; its label means nothing
    Point point;
    no_class += label && std::isnan(values[*label]);
    point.label = columns.id(label, values, place) & label_bits;
    point.instance = columns.id(instance, values, place);
    point.sigma = columns.sigma(sigma, values, place);
    builder.add(position, point);
  });
  LabelledCloud cloud = builder.finish(file.path());
  cloud.left_out.no_class = no_class;
  return cloud;
}

// ---- writing

using Header = std::string (*)(const std::vector<Column>& columns, std::uint64_t points,
                               const std::string& comments);

/// `colors`: columns of the colour of a class, which appendColor(row, color) writes. `mark`: before
/// comments. `scalar`: name of a column with the class as a float, or null.
template <class AppendColor>
void writePoints(const std::string& path, const LabelledCloud& cloud, const LabelSet* labels,
                 Header header, const char* mark, const char* scalar,
                 const std::vector<Column>& colors, AppendColor appendColor) {
  const bool doubles = needsDoubles(cloud), instances = cloud.hasInstances(),
             sigmas = cloud.hasSigmas();
  const ScalarType coordinates = doubles ? ScalarType::f64 : ScalarType::f32;
  std::vector<Column> columns;
  for (const char* axis : {"x", "y", "z"}) columns.push_back({axis, coordinates, 1, {}});
  if (labels) columns.insert(columns.end(), colors.begin(), colors.end());
  columns.push_back({"label", ScalarType::u32, 1, {}});
  if (labels && scalar) columns.push_back({scalar, ScalarType::f32, 1, {}});
  if (instances) columns.push_back({"instance", ScalarType::u32, 1, {}});
  if (sigmas) columns.push_back({"sigma", ScalarType::f32, 1, {}});
  const std::string beginning =
      header(columns, cloud.size(), labels ? classComments(*labels, mark) : std::string());
  requireReadable(path, beginning);
  AtomicFile file(path);
  file.write(beginning);
  std::string row;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    row.clear();
    const Eigen::Vector3d position = cloud.position(i);
    for (const double coordinate : position) {
      if (doubles) {
        appendNumber(row, coordinate);
      } else {
        appendNumber(row, static_cast<float>(coordinate));
      }
    }
    if (labels) appendColor(row, labels->color(cloud.points[i].label));
    appendNumber(row, cloud.points[i].label);
    if (labels && scalar) appendNumber(row, static_cast<float>(cloud.points[i].label));
    if (instances) appendNumber(row, cloud.points[i].instance);
    if (sigmas) appendNumber(row, cloud.points[i].sigma);
    file.write(row);
  }
  file.commit();
}

// ---- SemanticKITTI

constexpr std::size_t kLabelBytes = sizeof(std::uint32_t);

/// How far neighbours in a scan usually lie from one another, if its points have so many numbers.
float stepOf(const std::vector<float>& values, std::size_t numbers) {
  std::vector<float> steps;
  for (std::size_t i = numbers; i + 3 <= values.size(); i += numbers) {
    const float step = (Eigen::Map<const Eigen::Vector3f>(values.data() + i) -
                        Eigen::Map<const Eigen::Vector3f>(values.data() + i - numbers))
                           .norm();
    if (std::isfinite(step)) steps.push_back(step);
  }
  return steps.empty() ? 0 : medianOf(std::move(steps));
}

/// Numbers of a point: four, or five as nuScenes has them: each fifth one is whole, as the ring of
/// a laser is, and neighbours lie near one another.
std::size_t numbersOfScan(InputFile& scan) {
  constexpr std::size_t kLooked = 5000;
  constexpr float kMostRings = 255, kNearer = 0.5F;
  const std::size_t row = 5 * sizeof(float);
  if (scan.size() == 0 || scan.size() % row != 0) return 4;
  std::vector<float> values(5 * std::min<std::size_t>(kLooked / 5, scan.size() / row));
  scan.readBytes(values.data(), values.size() * sizeof(float));
  scan.seek(0);
  for (std::size_t i = 4; i < values.size(); i += 5) {
    if (!(values[i] >= 0 && values[i] <= kMostRings && values[i] == std::floor(values[i])))
      return 4;
  }
  return stepOf(values, 5) < kNearer * stepOf(values, 4) ? 5 : 4;
}

std::size_t pointCount(const InputFile& scan, std::size_t numbers) {
  const std::uint64_t points = scan.size() / (numbers * sizeof(float));
  if (scan.size() % (numbers * sizeof(float)) != 0) {
    scan.fail(
        "expected 16 bytes per point (x y z intensity), found {} bytes: {} are left after {} "
        "points",
        scan.size(), scan.size() % (numbers * sizeof(float)), points);
  }
  if (points > std::numeric_limits<std::int32_t>::max()) scan.fail("has more than 2^31 points");
  return static_cast<std::size_t>(points);
}

void requireLabels(const InputFile& labels, const InputFile& scan, std::size_t points) {
  if (labels.size() == points * kLabelBytes) return;
  labels.fail("expected {} labels of 4 bytes, one for each point of {}, found {} bytes", points,
              scan.path(), labels.size());
}

LabelledCloud readScan(InputFile& scan, std::optional<InputFile>& labels, std::size_t points,
                       std::size_t numbers) {
  std::vector<float> values(points * numbers);
  std::vector<std::uint32_t> ids(points, 0);
  scan.readBytes(values.data(), values.size() * sizeof(float));
  if (labels) labels->readBytes(ids.data(), points * kLabelBytes);
  LabelledCloud cloud;
  cloud.points.reserve(points);
  for (std::size_t i = 0; i < points; ++i) {
    const Eigen::Map<const Eigen::Vector3f> p(values.data() + i * numbers);
    if (!p.allFinite()) continue;
    Point point(p.x(), p.y(), p.z(), ids[i] & 0xFFFF);
    point.instance = ids[i] >> 16;
    cloud.points.push_back(point);
  }
  leaveOutStrays(scan.path(), cloud);
  return cloud;
}

}  // namespace

bool needsDoubles(const LabelledCloud& cloud) {
  constexpr double kFar_m = 1e4;
  if (cloud.origin.isZero(0)) return false;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!(cloud.position(i).cwiseAbs().maxCoeff() < kFar_m)) return true;
  }
  return false;
}

std::vector<std::string> cloudEndings() {
  std::vector<std::string> endings;
  for (const CloudFormat& format : kCloudFormats) endings.emplace_back(format.ending);
  return endings;
}

bool isCloudFile(const std::string& path) { return cloudFormatOf(path) != nullptr; }

float largestFloatCoordinate(const std::string& path) {
  struct Found {};  // one point is enough
  if (isTiledCloud(path)) return largestFloatCoordinate(firstTile(path));
  InputFile file(path);
  const FileLayout layout = readCloudLayout(file);
  const Element& points = pointsIn(layout, file);
  const ChosenColumns columns(points, file);
  float largest = 0;
  if (layout.encoding == Encoding::ascii || columns.column(0).type != ScalarType::f32) return 0;
  try {
    readTable(file, layout, points, columns.all(), [&](const double* p, const RowPlace&) {
      if (!std::isfinite(p[0] + p[1] + p[2])) return;
      largest = static_cast<float>(std::max({std::abs(p[0]), std::abs(p[1]), std::abs(p[2])}));
      throw Found();
    });
  } catch (const Found&) {
  }
  return largest;
}

ClassifiedPoints classifiedPoints(const std::string& path,
                                  const std::function<bool(const ClassifiedPoints&)>& isEnough) {
  struct Found {};
  constexpr std::uint32_t kTellNothing[] = {0, 1, 2, 7, 8, 12, 18, 20}, kLastUnclassified = 1;
  InputFile file(path);
  const FileLayout layout = readCloudLayout(file);
  const Element& points = pointsIn(layout, file);
  ClassifiedPoints result;
  const auto label = findIdColumns(points, {}, file).label;
  if (!label) return result;
  result.all = points.rows;
  try {
    readTable(file, layout, points, {*label}, [&](const double* value, const RowPlace&) {
      const auto id = static_cast<std::uint32_t>(*value) & layout.label_bits;
      const auto end = std::end(kTellNothing);
      result.classified += id > kLastUnclassified;
      result.telling += std::find(std::begin(kTellNothing), end, id) == end;
      if (isEnough(result)) throw Found();
    });
  } catch (const Found&) {
  }
  return result;
}

std::vector<std::string> setupsOf(const std::string& path) {
  if (endingOf(path) != ".e57") return {path};
  InputFile file(path);
  const std::size_t count = readCloudLayout(file).setups;
  if (count == 1) return {path};
  std::vector<std::string> setups;
  for (std::size_t i = 1; i <= count; ++i) setups.push_back(fmt::format("{}#{}", path, i));
  return setups;
}

CloudHeader readCloudHeader(const std::string& path, const CloudFields& fields) {
  if (isTiledCloud(path)) return readTiledHeader(path, fields);
  InputFile file(path);
  const FileLayout layout = readCloudLayout(file);
  const Element& points = pointsIn(layout, file);
  CloudHeader header;
  header.format = layout.format;
  header.points = static_cast<std::size_t>(points.rows);
  for (const Column& column : points.columns) header.fields.push_back(column.name);
  const IdColumns ids = findIdColumns(points, fields, file);
  if (ids.label) header.label_field = points.columns[*ids.label].name;
  if (ids.instance) header.instance_field = points.columns[*ids.instance].name;
  header.labels = readClassComments(layout.comments, file);
  header.georeference = layout.georeference;
  header.notes = layout.notes;
  return header;
}

LabelledCloud readCloud(const std::string& path, const CloudFields& fields, bool require_label) {
  if (isTiledCloud(path)) return readTiledCloud(path, fields, require_label);
  InputFile file(path);
  try {
    const FileLayout layout = readCloudLayout(file);
    const Element& points = pointsIn(layout, file);
    const IdColumns ids = findIdColumns(points, fields, file);
    if (require_label && !ids.label) {
      file.fail("has no label field, name one with --label-field; its fields: {}",
                points.columnNames());
    }
    LabelledCloud cloud =
        readPoints(file, layout, points, ids,
                   [&](const std::vector<std::size_t>& columns, const RowVisitor& visit) {
                     readTable(file, layout, points, columns, visit);
                   });
    if (layout.ends_with_rows) requireEnd(file, layout);
    return cloud;
  } catch (const std::bad_alloc&) {
    file.fail("needs more memory than there is for its {} bytes", file.size());
  }
}

LabelledCloud readStoredCloud(const InputFile& file, const Element& points, const StoredRows& rows,
                              const CloudFields& fields) {
  FileLayout layout;
  layout.encoding = Encoding::little_endian;
  return readPoints(file, layout, points, findIdColumns(points, fields, file),
                    [&](const std::vector<std::size_t>& columns, const RowVisitor& visit) {
                      readStoredRows(file, points, rows, columns, visit);
                    });
}

void writePcd(const std::string& path, const LabelledCloud& cloud, const LabelSet* labels) {
  // Red, green and blue in the bits 16-23, 8-15 and 0-7, as PCL packs them into its float field
  // "rgb".
  const std::vector<Column> colors{{"rgb", ScalarType::f32, 1, {}}};
  writePoints(path, cloud, labels, pcdHeader, "# ", nullptr, colors,
              [](std::string& row, const auto& color) {
                appendNumber(row, (std::uint32_t{color[0]} << 16) | (std::uint32_t{color[1]} << 8) |
                                      color[2]);
              });
}

void writePly(const std::string& path, const LabelledCloud& cloud, const LabelSet* labels) {
  std::vector<Column> colors;
  for (const char* name : {"red", "green", "blue"}) colors.push_back({name, ScalarType::u8, 1, {}});
  // Which CloudCompare takes for a scalar field.
  writePoints(path, cloud, labels, plyHeader, "comment ", "scalar_label", colors,
              [](std::string& row, const auto& color) {
                for (const std::uint8_t channel : color) appendNumber(row, channel);
              });
}

bool hasRings(const std::string& bin_path) {
  InputFile scan(bin_path);
  return numbersOfScan(scan) == 5;
}

LabelledCloud readKittiScan(const std::string& bin_path, const std::string& label_path) {
  InputFile scan(bin_path);
  std::optional<InputFile> labels;
  const std::size_t numbers = numbersOfScan(scan), points = pointCount(scan, numbers);
  if (!label_path.empty()) {
    labels.emplace(label_path);
    requireLabels(*labels, scan, points);
  }
  try {
    return readScan(scan, labels, points, numbers);
  } catch (const std::bad_alloc&) {
    scan.fail("needs more memory than there is for its {} points", points);
  }
}

}  // namespace xview::io
