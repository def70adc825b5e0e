// SPDX-License-Identifier: BSD-3-Clause
// The header of LAS files, versions 1.0 to 1.4, point formats 0 to 10, as the ASPRS specifies them
// (LAS 1.4 R15): little-endian, points with integer coordinates that a scale and an offset make
// metres.
#include <fmt/format.h>
#include <strings.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <string_view>

#include "base/user_text.h"
#include "las_writer.h"
#include "point_table.h"
#include "xview/base/error.h"

namespace xview::io {
namespace {

constexpr std::size_t kShortestHeader = 227;   ///< bytes of version 1.0
constexpr std::size_t kRecordHeader = 54;      ///< bytes before the content of a variable record
constexpr std::size_t kLongRecordHeader = 60;  ///< the same of those behind the points (1.4)
constexpr std::uint64_t kMostRecords = 100000;
constexpr std::uint64_t kLongestText = std::uint64_t{1} << 16;

/// A number at a byte of the header.
template <class T>
T at(const std::string& bytes, std::size_t position) {
  T value;
  std::memcpy(&value, bytes.data() + position, sizeof(T));
  return value;
}

std::string textAt(const std::string& bytes, std::size_t position, std::size_t length) {
  const std::string text = bytes.substr(position, length);
  return text.substr(0, text.find('\0'));
}

std::string readString(InputFile& file, std::uint64_t bytes) {
  if (bytes > file.remaining())
    file.fail("ends at byte {}, expected {} bytes more", file.size(), bytes - file.remaining());
  std::string text(static_cast<std::size_t>(bytes), '\0');
  file.readBytes(text.data(), text.size());
  return text;
}

// ---- points

using Columns = std::vector<Column>;

void addColumns(Columns& columns, ScalarType type, std::initializer_list<const char*> names) {
  for (const char* name : names) columns.push_back({name, type, 1, {}});
}

/// What is in all records of a point format, from 0 to 10.
Columns columnsOf(int format) {
  Columns columns;
  addColumns(columns, ScalarType::i32, {"X", "Y", "Z"});
  addColumns(columns, ScalarType::u16, {"intensity"});
  if (format < 6) {
    addColumns(columns, ScalarType::u8, {"flags", "classification"});
    addColumns(columns, ScalarType::i8, {"scan_angle"});
    addColumns(columns, ScalarType::u8, {"user_data"});
    addColumns(columns, ScalarType::u16, {"point_source"});
  } else {
    addColumns(columns, ScalarType::u8, {"returns", "flags", "classification", "user_data"});
    addColumns(columns, ScalarType::i16, {"scan_angle"});
    addColumns(columns, ScalarType::u16, {"point_source"});
  }
  if (format != 0 && format != 2) addColumns(columns, ScalarType::f64, {"gps_time"});
  const bool has_colours =
      format == 2 || format == 3 || format == 5 || format == 7 || format == 8 || format == 10;
  if (has_colours) addColumns(columns, ScalarType::u16, {"red", "green", "blue"});
  if (format == 8 || format == 10) addColumns(columns, ScalarType::u16, {"infrared"});
  if (format == 4 || format == 5 || format == 9 || format == 10) {
    addColumns(columns, ScalarType::u8, {"wave_packet"});
    addColumns(columns, ScalarType::u64, {"wave_offset"});
    addColumns(columns, ScalarType::u32, {"wave_size"});
    addColumns(columns, ScalarType::f32, {"wave_location", "wave_x", "wave_y", "wave_z"});
  }
  return columns;
}

/// The table of points, with one more column for what a record has beyond its format.
Element pointsOf(const std::string& header, const InputFile& file) {
  const int format = at<std::uint8_t>(header, 104);
  const std::uint16_t record = at<std::uint16_t>(header, 105);
  if (format & 0xC0)
    file.fail(
        "its points are compressed, as in .laz; unpack it: pdal translate FILE.laz FILE.las, or "
        "laszip -i FILE.laz -o FILE.las");
  if (format > 10) file.fail("expected a point format from 0 to 10, found {}", format);
  Element points;
  points.name = "point";
  points.columns = columnsOf(format);
  const std::uint64_t least = points.rowBytes();
  if (record < least)
    file.fail("points of format {} need {} bytes, its header says {}", format, least, record);
  if (record > least) points.columns.push_back({"extra_bytes", ScalarType::u8, record - least, {}});
  const bool is_long = at<std::uint8_t>(header, 25) >= 4;
  points.rows = at<std::uint32_t>(header, 107);
  if (is_long && at<std::uint64_t>(header, 247) != 0) points.rows = at<std::uint64_t>(header, 247);
  const std::uint64_t begin = at<std::uint32_t>(header, 96), room = file.size() - begin;
  if (points.rows == 0 && begin < file.size() && room >= record && !is_long)
    file.fail("its header counts 0 points, but has room for {} of {} bytes", room / record, record);
  return points;
}

void readScales(const std::string& header, const InputFile& file, FileLayout& layout) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto place = static_cast<std::size_t>(axis) * sizeof(double);
    layout.scale[axis] = at<double>(header, 131 + place);
    layout.offset[axis] = at<double>(header, 155 + place);
    if (!(std::isfinite(layout.scale[axis]) && layout.scale[axis] > 0))
      file.fail("expected a scale of {} above 0, found {}", "xyz"[axis], layout.scale[axis]);
    if (!std::isfinite(layout.offset[axis]))
      file.fail("expected a finite offset of {}, found {}", "xyz"[axis], layout.offset[axis]);
  }
}

// ---- variable records

/// What the records around the points say of the georeference and of the points.
struct Records {
  std::string wkt, ascii;              ///< texts of a coordinate system
  std::uint16_t epsg = 0;              ///< its number; 0 = not given
  bool is_geographic = false;          ///< its number is that of latitudes and longitudes
  double unit_m = 1, unit_of_z_m = 1;  ///< lengths that the keys state; of z as of x and y if none
  std::size_t extra = 0;               ///< bytes per point that the records describe
  std::vector<Column> extra_columns;   ///< these bytes, if all are plain numbers with a name
  std::vector<std::string> classes;    ///< lines of writeLas() that name them
};

/// Of EPSG: 9001 is the metre, 9002 the international foot, 9003 that of US surveys.
double metresOf(std::uint16_t unit, double otherwise) {
  return unit == 9001 ? 1 : unit == 9002 ? 0.3048 : unit == 9003 ? 1200.0 / 3937 : otherwise;
}

/// Keys 3072 (projected) and 2048 (geographic) of a GeoTIFF directory; 32767 is user-defined. 3076
/// and 4099 are the units of lengths and heights.
void takeKeys(const std::string& keys, Records& records) {
  std::uint16_t projected = 0, geographic = 0;
  std::uint16_t unit = 0, unit_of_z = 0;
  bool is_projected = false;  // also by a system without a number
  for (std::size_t i = 8; i + 8 <= keys.size(); i += 8) {
    const std::uint16_t key = at<std::uint16_t>(keys, i), place = at<std::uint16_t>(keys, i + 2),
                        value = at<std::uint16_t>(keys, i + 6);
    is_projected |= key == 3072;
    if (place != 0 || value == 0 || value == 32767) continue;
    if (key == 3072) projected = value;
    if (key == 2048) geographic = value;
    if (key == 3076) unit = value;
    if (key == 4099) unit_of_z = value;
  }
  records.unit_m = metresOf(unit, 1);
  records.unit_of_z_m = metresOf(unit_of_z, records.unit_m);
  records.is_geographic = !is_projected && geographic != 0;
  records.epsg = projected != 0 ? projected : geographic;
}

/// A record of extra bytes; each field takes 192 bytes to describe. One that a scale or an offset
/// belongs to is no plain number.
void takeExtraBytes(const std::string& content, Records& records) {
  constexpr std::array kTypes = {ScalarType::u8,  ScalarType::i8,  ScalarType::u16, ScalarType::i16,
                                 ScalarType::u32, ScalarType::i32, ScalarType::u64, ScalarType::i64,
                                 ScalarType::f32, ScalarType::f64};  // 1 to 10, then pairs, triples
  constexpr int kScaledOrShifted = 0x18;
  records.extra = 0;
  records.extra_columns.clear();
  bool are_plain = true;
  for (std::size_t i = 0; i + 192 <= content.size(); i += 192) {
    const std::size_t type = at<std::uint8_t>(content, i + 2);
    const std::uint8_t options = at<std::uint8_t>(content, i + 3);
    const ScalarType scalar = kTypes[(type + 9) % 10];
    if (type == 0) records.extra += options;
    if (type > 0 && type <= 30) records.extra += sizeOf(scalar) * ((type - 1) / 10 + 1);
    std::string name = textAt(content, i + 4, 32);
    std::replace_if(
        name.begin(), name.end(), [](unsigned char c) { return !std::isalnum(c); }, '_');
    are_plain &=
        type >= 1 && type <= kTypes.size() && !name.empty() && (options & kScaledOrShifted) == 0;
    records.extra_columns.push_back({name, scalar, 1, {}});
  }
  if (!are_plain) records.extra_columns.clear();
}

void takeRecord(const std::string& user, std::uint16_t id, std::uint64_t bytes, InputFile& file,
                Records& records) {
  const bool is_known = (user == "LASF_Projection" && (id == 2112 || id == 34735 || id == 34737)) ||
                        (user == "LASF_Spec" && id == 4) || (user == kLasUser && id == kLasClasses);
  if (!is_known || bytes > kLongestText) return file.seek(file.position() + bytes);
  const std::string content = readString(file, bytes);
  if (user == kLasUser) records.classes = linesOf(content);
  if (id == 2112) records.wkt = textAt(content, 0, content.size());
  if (id == 34737) records.ascii = textAt(content, 0, content.size());
  if (id == 34735) takeKeys(content, records);
  if (id == 4) takeExtraBytes(content, records);
}

/// The records between header and points.
void readRecords(InputFile& file, std::uint64_t count, std::uint64_t end, Records& records) {
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t room = end - file.position();
    const std::string head = room < kRecordHeader ? "" : readString(file, kRecordHeader);
    const std::uint64_t bytes = head.empty() ? 0 : at<std::uint16_t>(head, 20);
    if (head.empty() || bytes > room - kRecordHeader)
      file.fail("its variable record {} of {} goes beyond byte {}, where its points begin", i + 1,
                count, end);
    takeRecord(textAt(head, 2, 16), at<std::uint16_t>(head, 18), bytes, file, records);
  }
}

/// The records behind the points. A file that was cut off there still has all its points; what of
/// its records is missing is left out.
void readRecordsBehind(InputFile& file, const std::string& header, Records& records) {
  const std::uint64_t begin = at<std::uint64_t>(header, 235);
  const std::uint32_t count = at<std::uint32_t>(header, 243);
  if (count == 0 || begin > file.size() || count > kMostRecords) return;
  file.seek(begin);
  for (std::uint32_t i = 0; i < count && file.remaining() >= kLongRecordHeader; ++i) {
    const std::string head = readString(file, kLongRecordHeader);
    const std::uint64_t bytes = at<std::uint64_t>(head, 20);
    if (bytes > file.remaining()) return;
    takeRecord(textAt(head, 2, 16), at<std::uint16_t>(head, 18), bytes, file, records);
  }
}

std::string georeferenceOf(const Records& records) {
  if (!records.wkt.empty()) return records.wkt;
  std::string text = records.ascii;
  std::replace(text.begin(), text.end(), '|', ' ');
  if (records.epsg == 0) return text;
  const std::string code = fmt::format("EPSG:{}", records.epsg);
  return text.empty() ? code : code + " " + text;
}

/// Throws Error if x and y are longitude and latitude.
void requireLengths(const std::string& header, const Records& records, const InputFile& file) {
  const bool by_text = records.wkt.find("PROJC") == std::string::npos &&
                       (records.wkt.find("GEOG") != std::string::npos ||
                        records.wkt.find("GEODCRS") != std::string::npos);
  const double west = at<double>(header, 187), south = at<double>(header, 203);
  if (!(records.wkt.empty() ? records.is_geographic : by_text) ||
      !(std::abs(west) <= 180 && std::abs(south) <= 90))
    return;
  const int zone = std::min(60, 1 + static_cast<int>(std::floor((west + 180) / 6)));
  file.fail(
      "its x and y are degrees ({}), not metres; reproject it: pdal translate {} OUT.las "
      "reprojection --filters.reprojection.out_srs=EPSG:{}",
      records.epsg != 0 ? fmt::format("EPSG:{}", records.epsg) : std::string("WKT"), file.path(),
      (south < 0 ? 32700 : 32600) + zone);
}

/// The last unit of lengths in a part of a WKT text: those of ellipsoids and parameters stand
/// before that of the axes, and units of angles are none.
double unitIn(const std::string& wkt, double otherwise) {
  constexpr double kDegree_rad = M_PI / 180, kShortest_m = 1e-4, kLongest_m = 1e4;
  double found = otherwise;
  for (std::size_t at = wkt.find("UNIT["); at != std::string::npos;
       at = wkt.find("UNIT[", at + 1)) {
    const std::string before = wkt.substr(at < 6 ? 0 : at - 6, std::min<std::size_t>(at, 6));
    const bool is_whole_word =
        before.empty() || !std::isalpha(static_cast<unsigned char>(before.back()));
    const std::size_t name_end = wkt.find('"', wkt.find('"', at) + 1);
    if (name_end == std::string::npos || !(is_whole_word || before == "LENGTH")) continue;
    const std::size_t number = wkt.find_first_not_of(", \t\r\n", name_end + 1);
    if (number == std::string::npos) continue;
    const std::size_t number_end = wkt.find_first_of(",] \t\r\n", number);
    const auto metres =
        numberFrom<double>(std::string_view(wkt).substr(number, number_end - number));
    if (metres && *metres > kShortest_m && *metres < kLongest_m &&
        std::abs(*metres - kDegree_rad) > 1e-4)
      found = *metres;
  }
  return found;
}

/// Makes the lengths of a file metres by the units that it states.
void useUnits(const Records& records, FileLayout& layout) {
  double unit_m = records.unit_m, unit_of_z_m = records.unit_of_z_m;
  if (!records.wkt.empty()) {
    std::size_t vertical = std::string::npos;
    for (const char* system : {"VERT_CS[", "VERTCS[", "VERTCRS[", "VERTICALCRS["})
      vertical = std::min(vertical, records.wkt.find(system));
    unit_m = unitIn(records.wkt.substr(0, vertical), 1);
    unit_of_z_m =
        vertical == std::string::npos ? unit_m : unitIn(records.wkt.substr(vertical), unit_m);
  }
  layout.unit_m = {unit_m, unit_m, unit_of_z_m};
  if ((layout.unit_m == 1).all()) return;
  layout.scale *= layout.unit_m;
  layout.offset *= layout.unit_m;
  layout.notes.push_back(fmt::format(
      "its georeference states lengths of {:.7g} m and heights of {:.7g} m; made metres", unit_m,
      unit_of_z_m));
}

/// Whether a field of this name, in whatever case, is there, or would be taken for one of those
/// that are used.
bool hasMeaning(const std::string& name, const Element& points) {
  constexpr const char* kMeanings[] = {"x", "y", "z", "rgb", "rgba", "sigma", "normal", "time"};
  const auto is = [&](const std::string& other) {
    return strcasecmp(name.c_str(), other.c_str()) == 0;
  };
  return namesId(name) || std::any_of(std::begin(kMeanings), std::end(kMeanings), is) ||
         std::any_of(points.columns.begin(), points.columns.end(),
                     [&](const Column& column) { return is(column.name); });
}

/// The fixed part, as long as the header says that it is; it must be of a version that is known.
std::string readFixedHeader(InputFile& file) {
  if (file.size() < kShortestHeader)
    file.fail("expected a LAS header of {} bytes, the file has {}", kShortestHeader, file.size());
  std::string header = readString(file, kShortestHeader);
  if (header.compare(0, 4, "LASF") != 0)
    file.fail("expected a LAS file, which begins with LASF, found {}",
              inQuotes(std::string_view(header).substr(0, 4)));
  const int major = at<std::uint8_t>(header, 24), minor = at<std::uint8_t>(header, 25);
  if (major != 1 || minor > 4) file.fail("expected LAS 1.0 to 1.4, found {}.{}", major, minor);
  const std::uint16_t size = at<std::uint16_t>(header, 94);
  const std::size_t least = minor == 4 ? 375 : minor == 3 ? 235 : kShortestHeader;
  if (size < least)
    file.fail("a header of LAS 1.{} has {} bytes, this one says {}", minor, least, size);
  return header + readString(file, size - kShortestHeader);
}

}  // namespace

FileLayout readLasHeader(InputFile& file) {
  const std::string header = readFixedHeader(file);
  const std::uint32_t begin = at<std::uint32_t>(header, 96);
  if (begin < header.size() || begin > file.size())
    file.fail("its points begin at byte {}, expected {} to {}", begin, header.size(), file.size());
  FileLayout layout;
  layout.encoding = Encoding::little_endian;
  layout.format = fmt::format("LAS 1.{} point format {}", at<std::uint8_t>(header, 25),
                              at<std::uint8_t>(header, 104));
  layout.elements.push_back(pointsOf(header, file));
  readScales(header, file, layout);
  if (at<std::uint8_t>(header, 104) < 6) layout.label_bits = 0x1F;  // above them are flags
  Records records;
  readRecords(file, at<std::uint32_t>(header, 100), begin, records);
  if (at<std::uint8_t>(header, 25) >= 4) readRecordsBehind(file, header, records);
  requireLengths(header, records, file);
  useUnits(records, layout);
  layout.georeference = georeferenceOf(records);
  layout.comments = std::move(records.classes);
  const Column& last = layout.elements[0].columns.back();
  const std::size_t beyond = last.name == "extra_bytes" ? last.count : 0;
  if (records.extra > beyond)
    layout.notes.push_back(fmt::format(
        "its header describes {} extra bytes a point, but its points have {}; none is read",
        records.extra, beyond));
  if (records.extra == beyond && !records.extra_columns.empty()) {
    Element& points = layout.elements[0];
    points.columns.pop_back();
    for (Column& column : records.extra_columns) {
      // What somebody added is not taken for a coordinate, a class or a colour by its name.
      if (hasMeaning(column.name, points)) column.name = "extra_" + column.name;
      points.columns.push_back(std::move(column));
    }
  }
  file.seek(begin);
  layout.ends_with_rows = false;  // waveforms and records may follow
  return layout;
}

}  // namespace xview::io
