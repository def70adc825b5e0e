// SPDX-License-Identifier: BSD-3-Clause
// A cloud file again, moved, with all that its points have.
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>

#include "las_writer.h"
#include "point_table.h"
#include "process/atomic_file.h"
#include "xview/base/error.h"
#include "xview/io/cloud_files.h"

namespace xview::io {
namespace {

/// Calls use(T()) with the type of a column.
template <class Use>
void withType(ScalarType type, const Use& use) {
  switch (type) {
    case ScalarType::i8:
      return use(std::int8_t());
    case ScalarType::u8:
      return use(std::uint8_t());
    case ScalarType::i16:
      return use(std::int16_t());
    case ScalarType::u16:
      return use(std::uint16_t());
    case ScalarType::i32:
      return use(std::int32_t());
    case ScalarType::u32:
      return use(std::uint32_t());
    case ScalarType::i64:
      return use(std::int64_t());
    case ScalarType::u64:
      return use(std::uint64_t());
    case ScalarType::f32:
      return use(float());
    case ScalarType::f64:
      return use(double());
  }
}

/// A number of a field in its type. What it has no room for becomes the nearest, NaN becomes 0, and
/// -1 in a field without signs the largest.
template <class T>
T stored(double value) {
  if constexpr (std::is_floating_point_v<T>) return static_cast<T>(value);
  constexpr double kLowest = static_cast<double>(std::numeric_limits<T>::lowest()),
                   kMost = static_cast<double>(std::numeric_limits<T>::max());
  if (std::isnan(value)) return 0;
  if ((std::is_unsigned_v<T> && value == -1) || value >= kMost)
    return std::numeric_limits<T>::max();
  return value <= kLowest ? std::numeric_limits<T>::lowest() : static_cast<T>(value);
}

/// The points of a file with their fields of one number each, as often as they are asked for.
class Source {
 public:
  /// `labels`: what its classes are; null if it has none.
  Source(const std::string& path, const LabelSet* labels) : path_(path) {
    InputFile file(path);
    layout_ = layoutOf(file);
    const Element& points = pointsIn(layout_, file);
    const ChosenColumns columns(points, file);
    ids_ = findIdColumns(points, {}, file);
    chosen_ = columns.all();
    setClasses(labels);
    for (const Element& element : layout_.elements) {
      if (element.name != points.name) left_out_.push_back(element.name);
    }
    for (std::size_t i = 0; i < points.columns.size(); ++i) {
      const Column& column = points.columns[i];
      if (std::find(chosen_.begin(), chosen_.end(), i) != chosen_.end()) continue;
      const bool is_turned_normal = column.name.rfind("nor:", 0) == 0;  // as its setup stood
      if (column.count != 1 || column.list_size || is_turned_normal || isOfSomeScans(column.name))
        left_out_.push_back(column.name);
      else
        chosen_.push_back(i);
    }
    for (const std::string& name : layout_.of_some_scans) {
      if (std::find(left_out_.begin(), left_out_.end(), name) == left_out_.end())
        left_out_.push_back(name);
    }
    renameColours();
  }

  const FileLayout& layout() const { return layout_; }
  const std::vector<std::string>& leftOut() const { return left_out_; }
  std::size_t fields() const { return chosen_.size(); }
  const Column& field(std::size_t i) const { return points().columns[chosen_[i]]; }
  std::uint64_t rows() const { return points().rows; }
  /// Position of the first field of one of the names, in letters of either case.
  std::optional<std::size_t> find(std::initializer_list<const char*> names) const {
    for (const std::string name : names) {
      for (std::size_t i = 3; i < fields(); ++i) {
        std::string of_file = field(i).name;
        std::transform(of_file.begin(), of_file.end(), of_file.begin(),
                       [](unsigned char c) { return std::tolower(c); });
        if (of_file == name || of_file == "scalar_" + name) return i;
      }
    }
    return std::nullopt;
  }
  std::optional<std::size_t> label() const {
    if (!ids_.label) return std::nullopt;
    const auto at = std::find(chosen_.begin(), chosen_.end(), *ids_.label);
    return static_cast<std::size_t>(at - chosen_.begin());
  }
  std::uint32_t labelBits() const { return layout_.label_bits; }

  /// visit(position, values) for each row; x y z are the first three values.
  template <class Visit>
  void forRows(const Visit& visit) const {
    InputFile file(path_);
    const FileLayout layout = layoutOf(file);
    readTable(
        file, layout, pointsIn(layout, file), chosen_, [&](const double* values, const RowPlace&) {
          visit(Eigen::Vector3d(Eigen::Array3d(values[0], values[1], values[2]) * layout.scale +
                                layout.offset),
                values);
        });
    if (layout.ends_with_rows) requireEnd(file, layout);
  }

 private:
  /// The comments that name them, instead of those of the file.
  void setClasses(const LabelSet* labels) {
    std::vector<std::string>& comments = layout_.comments;
    if (!labels && comments.empty() && layout_.format.rfind("LAS", 0) == 0) {
      // Classes of LAS that tell nothing would be classes in a file of another kind.
      for (Column& column : layout_.elements.front().columns) {
        if (column.name == "classification") column.name = "las_classification";
      }
    }
    if (!labels) return;
    comments.erase(std::remove_if(comments.begin(), comments.end(),
                                  [](const std::string& c) { return c.rfind("xview ", 0) == 0; }),
                   comments.end());
    for (std::string& line : linesOf(classComments(*labels, "")))
      comments.push_back(std::move(line));
  }
  bool isOfSomeScans(const std::string& name) const {
    const std::vector<std::string>& some = layout_.of_some_scans;
    return std::find(some.begin(), some.end(), name) != some.end();
  }
  /// Those of an E57 to what PLY calls them.
  void renameColours() {
    for (Column& column : layout_.elements.front().columns) {
      for (const char* color : {"Red", "Green", "Blue"}) {
        if (column.name == std::string("color") + color)
          column.name = std::string(1, static_cast<char>(std::tolower(color[0]))) + (color + 1);
      }
    }
  }
  /// Colours that PCL packs into a float are read as bits: as numbers some are not finite.
  static FileLayout layoutOf(InputFile& file) {
    FileLayout layout = readCloudLayout(file);
    for (Element& element : layout.elements) {
      for (Column& column : element.columns) {
        if (column.type == ScalarType::f32 && layout.encoding != Encoding::ascii &&
            (column.name == "rgb" || column.name == "rgba"))
          column.type = ScalarType::u32;
      }
    }
    return layout;
  }
  const Element& points() const {
    const Element* found = layout_.findElement("point");
    return found ? *found : *layout_.findElement("vertex");
  }

  std::string path_;
  FileLayout layout_;
  IdColumns ids_;
  std::vector<std::size_t> chosen_;  ///< x, y, z, then the others in their order
  std::vector<std::string> left_out_;
};

/// The three fields of normals, if the points have them.
std::optional<std::size_t> normalsOf(const Source& source) {
  const auto x = source.find({"normal_x", "nx"});
  return x && source.find({"normal_z", "nz"}) == *x + 2 ? x : std::nullopt;
}

/// Those that are written; coordinates have the type of that name.
std::vector<Column> columnsOf(const Source& source, ScalarType coordinates) {
  std::vector<Column> columns;
  for (std::size_t i = 0; i < source.fields(); ++i)
    columns.push_back(i < 3 ? Column{std::string(1, "xyz"[i]), coordinates, 1, {}}
                            : source.field(i));
  return columns;
}

/// True if its coordinates are doubles.
bool copyTable(const Source& source, const std::string& to, const Eigen::Affine3d& moved) {
  constexpr double kFar_m = 1e4;  // where float32 has no millimetres
  const double scale = std::cbrt(moved.linear().determinant());
  const Eigen::Matrix3d turn = moved.linear() / scale;
  const auto normals = normalsOf(source), label = source.label(), sigma = source.find({"sigma"});
  double farthest_m = 0;
  source.forRows([&](const Eigen::Vector3d& p, const double*) {
    const Eigen::Vector3d there = moved * p;
    if (there.allFinite()) farthest_m = std::max(farthest_m, there.cwiseAbs().maxCoeff());
  });
  const ScalarType coordinates = farthest_m < kFar_m ? ScalarType::f32 : ScalarType::f64;
  const std::vector<Column> columns = columnsOf(source, coordinates);
  const bool is_pcd = endingOf(to) == ".pcd";
  std::string comments;
  for (const std::string& comment : source.layout().comments)
    comments += (is_pcd ? "# " : "comment ") + comment + "\n";
  const std::string header = (is_pcd ? pcdHeader : plyHeader)(columns, source.rows(), comments);
  requireReadable(to, header);
  AtomicFile file(to);
  file.write(header);
  std::string row;
  std::vector<double> values(source.fields());
  source.forRows([&](const Eigen::Vector3d& p, const double* of_file) {
    std::copy(of_file, of_file + values.size(), values.begin());
    Eigen::Map<Eigen::Vector3d>(values.data()) = moved * p;
    if (normals) {
      Eigen::Map<Eigen::Vector3d> normal(values.data() + *normals);
      normal = (turn * normal).eval();
    }
    if (label && source.labelBits() != ~std::uint32_t{0})
      values[*label] = static_cast<std::uint32_t>(values[*label]) & source.labelBits();
    if (sigma) values[*sigma] *= scale;
    row.clear();
    for (std::size_t i = 0; i < values.size(); ++i)
      withType(columns[i].type,
               [&](auto type) { appendNumber(row, stored<decltype(type)>(values[i])); });
    file.write(row);
  });
  file.commit();
  return coordinates == ScalarType::f64;
}

/// The nearest whole number that is not negative and has room.
template <class Integer>
Integer within(double value) {
  return stored<Integer>(std::round(std::max(0.0, value)));  // of NaN 0
}

/// Returns the fields for which LAS has no place.
std::vector<std::string> copyToLas(const Source& source, const std::string& to,
                                   const Eigen::Affine3d& moved) {
  using Field = std::optional<std::size_t>;
  const Field intensity = source.find({"intensity", "reflectance", "reflectivity"}),
              time = source.find({"gps_time", "gpstime", "time", "timestamp", "t", "stamp"}),
              number = source.find({"return_number", "returnnumber"}),
              returns = source.find({"number_of_returns", "numberofreturns", "returncount"}),
              of_source = source.find({"point_source", "point_source_id", "ring"}),
              red = source.find({"red", "r"}), green = source.find({"green", "g"}),
              blue = source.find({"blue", "b"}), packed = source.find({"rgb", "rgba"}),
              label = source.label();
  double brightest = 0, brightest_color = 0;  // shares of 1, or counts
  source.forRows([&](const Eigen::Vector3d&, const double* values) {
    if (intensity) brightest = std::max(brightest, values[*intensity]);
    for (const auto& color : {red, green, blue}) {
      if (color) brightest_color = std::max(brightest_color, values[*color]);
    }
  });
  const auto isShare = [&](const Field& field, double most) {
    return field && most <= 1 && !isInteger(source.field(*field).type);
  };
  const double gain = isShare(intensity, brightest) ? 65535 : 1;
  const double color_gain = isShare(red, brightest_color) ? 65535
                            : brightest_color <= 255      ? 257
                                                          : 1;
  const auto points = [&](const std::function<void(const LasPoint&)>& visit) {
    source.forRows([&](const Eigen::Vector3d& p, const double* values) {
      LasPoint point;
      point.position = moved * p;
      const bool is_none = label && values[*label] >= 4294967295.0;  // -1 without a sign
      if (label && !is_none)
        point.label = within<std::uint32_t>(values[*label]) & source.labelBits();
      if (intensity) point.intensity = within<std::uint16_t>(gain * values[*intensity]);
      if (time) point.gps_time = values[*time];
      constexpr std::uint8_t kMostReturns = 15;
      if (number)
        point.return_number = std::min(kMostReturns, within<std::uint8_t>(values[*number]));
      if (returns) point.returns = std::min(kMostReturns, within<std::uint8_t>(values[*returns]));
      if (of_source) point.source = within<std::uint16_t>(values[*of_source]);
      if (red && green && blue)
        point.color = {within<std::uint16_t>(color_gain * values[*red]),
                       within<std::uint16_t>(color_gain * values[*green]),
                       within<std::uint16_t>(color_gain * values[*blue])};
      if (packed) {
        const auto as_float = static_cast<float>(values[*packed]);
        auto bits = within<std::uint32_t>(values[*packed]);
        if (source.field(*packed).type == ScalarType::f32) std::memcpy(&bits, &as_float, 4);
        for (int c = 0; c < 3; ++c)
          point.color[static_cast<std::size_t>(c)] =
              static_cast<std::uint16_t>(257 * (bits >> (16 - 8 * c) & 0xFF));
      }
      visit(point);
    });
  };
  std::string classes;
  for (const std::string& comment : source.layout().comments) {
    if (comment.rfind("xview ", 0) == 0) classes += comment + "\n";
  }
  writeLas(to, points, classes);
  std::vector<std::string> left_out;
  const Field kept[] = {intensity, time,  number, returns, of_source,
                        red,       green, blue,   packed,  label};
  for (std::size_t i = 3; i < source.fields(); ++i) {
    if (std::find(std::begin(kept), std::end(kept), Field(i)) == std::end(kept))
      left_out.push_back(source.field(i).name);
  }
  return left_out;
}

}  // namespace

std::vector<std::string> copyCloud(const std::string& from, const std::string& to,
                                   const Eigen::Affine3d& moved, const LabelSet* labels) {
  if (endingOf(from) == ".las" && endingOf(to) == ".las") {
    copyLas(from, to, moved);
    if (readCloudHeader(from).georeference.empty() || moved.isApprox(Eigen::Affine3d::Identity()))
      return {};
    return {"the copy names the coordinate system of the input, wherever it was moved to"};
  }
  const Source source(from, labels);
  std::vector<std::string> notes;
  if (!source.leftOut().empty())
    notes.push_back(fmt::format("left out, as it is not one number of each point: {}",
                                fmt::join(source.leftOut(), ", ")));
  if (endingOf(to) != ".las") {
    if (copyTable(source, to, moved))
      notes.emplace_back(
          "its coordinates are doubles, as float32 has no millimetres 10 km from the origin; "
          "pcl_viewer and PCL read float32 only");
    return notes;
  }
  if (const auto no_place = copyToLas(source, to, moved); !no_place.empty())
    notes.push_back(
        fmt::format("left out, as LAS has no place for it: {}; points that are not "
                    "finite are left out as well",
                    fmt::join(no_place, ", ")));
  return notes;
}

void writeLas(const std::string& path, const LabelledCloud& cloud, const LabelSet* labels) {
  const auto points = [&](const std::function<void(const LasPoint&)>& visit) {
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      LasPoint point;
      point.position = cloud.position(i);
      point.label = cloud.points[i].label;
      point.source = static_cast<std::uint16_t>(cloud.points[i].instance & 0xFFFF);
      for (std::size_t c = 0; labels && c < 3; ++c)
        point.color[c] = static_cast<std::uint16_t>(257 * labels->color(point.label)[c]);
      visit(point);
    }
  };
  writeLas(path, points, labels ? classComments(*labels, "") : std::string());
}

}  // namespace xview::io
