// SPDX-License-Identifier: BSD-3-Clause
// A cloud file again, moved, with all that its points have.
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "las_writer.h"
#include "point_table.h"
#include "process/atomic_file.h"
#include "xview/base/error.h"
#include "xview/io/cloud_files.h"
#include "xview/io/label_files.h"

namespace xview::io {
namespace {

template <class T>
void pack(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

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

/// The points of a file with their fields of one number each, as often as they are asked for.
class Source {
 public:
  explicit Source(const std::string& path) : path_(path) {
    InputFile file(path);
    layout_ = layoutOf(file);
    const Element& points = pointsIn(layout_, file);
    const ChosenColumns columns(points, file);
    ids_ = findIdColumns(points, {}, file);
    chosen_ = columns.all();
    if (layout_.format.rfind("LAS", 0) == 0 && layout_.comments.empty())
      layout_.comments = linesOf(classComments(shippedLabelSet("las"), ""));
    for (std::size_t i = 0; i < points.columns.size(); ++i) {
      const Column& column = points.columns[i];
      if (std::find(chosen_.begin(), chosen_.end(), i) != chosen_.end()) continue;
      if (column.count != 1 || column.list_size)
        left_out_.push_back(column.name);
      else
        chosen_.push_back(i);
    }
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
        std::transform(of_file.begin(), of_file.end(), of_file.begin(), ::tolower);
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

std::string pcdHeader(const Source& source, ScalarType coordinates) {
  std::string fields, sizes, types, counts, comments;
  for (std::size_t i = 0; i < source.fields(); ++i) {
    const ScalarType type = i < 3 ? coordinates : source.field(i).type;
    const bool is_signed = isInteger(type) && static_cast<int>(type) % 2 == 0;
    fields += " " + (i < 3 ? std::string(1, "xyz"[i]) : source.field(i).name);
    sizes += fmt::format(" {}", sizeOf(type));
    types += !isInteger(type) || source.field(i).name == "rgb" ? " F" : is_signed ? " I" : " U";
    counts += " 1";
  }
  for (const std::string& comment : source.layout().comments) comments += "# " + comment + "\n";
  return fmt::format(
      "# .PCD v0.7 - Point Cloud Data file format\n{}VERSION 0.7\nFIELDS{}\nSIZE{}\nTYPE{}\n"
      "COUNT{}\nWIDTH {}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA binary\n",
      comments, fields, sizes, types, counts, source.rows(), source.rows());
}

std::string plyHeader(const Source& source, ScalarType coordinates) {
  constexpr const char* kTypes[] = {"char", "uchar", "short",  "ushort", "int",
                                    "uint", "int64", "uint64", "float",  "double"};
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  for (const std::string& comment : source.layout().comments) header += "comment " + comment + "\n";
  header += fmt::format("element vertex {}\n", source.rows());
  for (std::size_t i = 0; i < source.fields(); ++i) {
    const ScalarType type = i < 3 ? coordinates : source.field(i).type;
    header += fmt::format("property {} {}\n", kTypes[static_cast<int>(type)],
                          i < 3 ? std::string(1, "xyz"[i]) : source.field(i).name);
  }
  return header + "end_header\n";
}

void copyTable(const Source& source, const std::string& to, const Eigen::Affine3d& moved) {
  constexpr double kFar_m = 1e4;  // where float32 has no millimetres
  const Eigen::Matrix3d turn = moved.linear() / std::cbrt(moved.linear().determinant());
  const auto normals = normalsOf(source), label = source.label();
  double farthest_m = 0;
  source.forRows([&](const Eigen::Vector3d& p, const double*) {
    const Eigen::Vector3d there = moved * p;
    if (there.allFinite()) farthest_m = std::max(farthest_m, there.cwiseAbs().maxCoeff());
  });
  const ScalarType coordinates = farthest_m < kFar_m ? ScalarType::f32 : ScalarType::f64;
  const std::string header =
      endingOf(to) == ".pcd" ? pcdHeader(source, coordinates) : plyHeader(source, coordinates);
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
    row.clear();
    for (std::size_t i = 0; i < values.size(); ++i)
      withType(i < 3 ? coordinates : source.field(i).type,
               [&](auto type) { pack(row, static_cast<decltype(type)>(values[i])); });
    file.write(row);
  });
  file.commit();
}

template <class Integer>
Integer within(double value) {
  return static_cast<Integer>(
      std::clamp(std::round(value), 0.0, double{std::numeric_limits<Integer>::max()}));
}

void copyToLas(const Source& source, const std::string& to, const Eigen::Affine3d& moved) {
  const auto intensity = source.find({"intensity", "reflectance", "reflectivity"}),
             time = source.find({"gps_time", "gpstime", "time", "timestamp", "t", "stamp"}),
             number = source.find({"return_number", "returnnumber", "returnindex"}),
             returns = source.find({"number_of_returns", "numberofreturns", "returncount"}),
             of_source = source.find({"point_source", "point_source_id", "ring"}),
             red = source.find({"red", "r", "colorred"}),
             green = source.find({"green", "g", "colorgreen"}),
             blue = source.find({"blue", "b", "colorblue"}), packed = source.find({"rgb", "rgba"}),
             label = source.label();
  double brightest = 0, reddest = 0;  // shares of 1, or counts
  source.forRows([&](const Eigen::Vector3d&, const double* values) {
    if (intensity) brightest = std::max(brightest, values[*intensity]);
    if (red) reddest = std::max({reddest, values[*red], green ? values[*green] : 0});
  });
  const double gain = brightest <= 1 ? 65535 : 1;
  const double color_gain = reddest <= 1 ? 65535 : reddest <= 255 ? 257 : 1;
  const auto points = [&](const std::function<void(const LasPoint&)>& visit) {
    source.forRows([&](const Eigen::Vector3d& p, const double* values) {
      LasPoint point;
      point.position = moved * p;
      if (label && values[*label] > 0)
        point.label = static_cast<std::uint32_t>(values[*label]) & source.labelBits();
      if (intensity) point.intensity = within<std::uint16_t>(gain * values[*intensity]);
      if (time) point.gps_time = values[*time];
      if (number) point.return_number = within<std::uint8_t>(values[*number]);
      if (returns) point.returns = within<std::uint8_t>(values[*returns]);
      if (of_source) point.source = within<std::uint16_t>(values[*of_source]);
      if (red && green && blue)
        point.color = {within<std::uint16_t>(color_gain * values[*red]),
                       within<std::uint16_t>(color_gain * values[*green]),
                       within<std::uint16_t>(color_gain * values[*blue])};
      if (packed) {
        const auto as_float = static_cast<float>(values[*packed]);
        auto bits = static_cast<std::uint32_t>(std::max(0.0, values[*packed]));
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
}

}  // namespace

std::vector<std::string> copyCloud(const std::string& from, const std::string& to,
                                   const Eigen::Affine3d& moved) {
  if (endingOf(from) == ".las" && endingOf(to) == ".las") {
    copyLas(from, to, moved);
    return {};
  }
  const Source source(from);
  if (endingOf(to) == ".las")
    copyToLas(source, to, moved);
  else
    copyTable(source, to, moved);
  if (source.leftOut().empty()) return {};
  return {fmt::format("fields of more than one number are left out: {}",
                      fmt::join(source.leftOut(), ", "))};
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
