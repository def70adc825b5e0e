// SPDX-License-Identifier: BSD-3-Clause
// The points of E57 files as a table, whatever is packed how.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>

#include "document.h"
#include "io/point_table.h"

namespace xview::io {
namespace {

using Slot = std::optional<std::size_t>;  ///< position among the fields of a scan; none: not there

Slot findField(const E57Scan& scan, const std::string& name) {
  for (std::size_t i = 0; i < scan.fields.size(); ++i)
    if (scan.fields[i].name == name) return i;
  return std::nullopt;
}

/// Where a scan has its coordinates: along the axes, or as range, azimuth and elevation.
struct Coordinates {
  std::array<std::size_t, 3> fields{};
  bool is_spherical = false;
  Slot invalid;  ///< 0 where the point is measured

  Coordinates(const E57Scan& scan, const InputFile& file) {
    is_spherical = !findField(scan, "cartesianX");
    const std::string kind = is_spherical ? "spherical" : "cartesian";
    std::size_t axis = 0;
    for (const char* end :
         is_spherical ? std::array{"Range", "Azimuth", "Elevation"} : std::array{"X", "Y", "Z"}) {
      const Slot field = findField(scan, kind + end);
      if (!field) file.fail("a scan has points without {}{}", kind, end);
      fields[axis++] = *field;
    }
    invalid = findField(scan, kind + "InvalidState");
  }

  Eigen::Vector3d of(const std::vector<double>& values) const {
    const double a = values[fields[0]], b = values[fields[1]], c = values[fields[2]];
    if (!is_spherical) return {a, b, c};
    return {a * std::cos(c) * std::cos(b), a * std::cos(c) * std::sin(b), a * std::sin(c)};
  }
};

/// The values of one field, whose bits come in pieces.
class Bits {
 public:
  explicit Bits(const E57Field& field) : field_(field) {}

  void append(E57Pages& pages, std::size_t bytes) {
    bytes_.erase(0, bit_ / 8);
    bit_ %= 8;
    const std::size_t begin = bytes_.size();
    bytes_.resize(begin + bytes);
    pages.read(&bytes_[begin], bytes);
  }
  bool hasNext() const { return 8 * bytes_.size() - bit_ >= static_cast<std::size_t>(field_.bits); }
  double next() {
    const std::uint64_t bits = take();
    if (!field_.is_real) {
      const std::uint64_t whole = static_cast<std::uint64_t>(field_.minimum) + bits;
      return field_.offset + field_.scale * static_cast<double>(static_cast<std::int64_t>(whole));
    }
    if (field_.bits == 64) return realOf<double>(bits);
    return realOf<float>(static_cast<std::uint32_t>(bits));
  }

 private:
  template <class Real, class Stored>
  static Real realOf(Stored bits) {
    static_assert(sizeof(Real) == sizeof(Stored));
    Real real;
    std::memcpy(&real, &bits, sizeof(Real));
    return real;
  }
  std::uint64_t take() {
    std::uint64_t value = 0;
    for (int taken = 0; taken < field_.bits;) {
      const int from = static_cast<int>(bit_ % 8), some = std::min(8 - from, field_.bits - taken);
      const auto byte = static_cast<std::uint8_t>(bytes_[bit_ / 8]);
      value |= static_cast<std::uint64_t>(byte >> from & ((1 << some) - 1)) << taken;
      taken += some;
      bit_ += static_cast<std::size_t>(some);
    }
    return value;
  }

  const E57Field& field_;
  std::string bytes_;
  std::size_t bit_ = 0;  ///< the next one
};

/// Visits the points of one scan as they come out of its packets.
class ScanReader {
 public:
  /// `chosen` is where the values of each column are: below 3 the axes, else 3 + field.
  ScanReader(E57Pages& pages, const E57Scan& scan, std::vector<std::size_t> chosen)
      : pages_(pages),
        scan_(scan),
        coordinates_(scan, pages.file()),
        chosen_(std::move(chosen)),
        is_needed_(scan.fields.size()) {
    for (const E57Field& field : scan.fields) streams_.emplace_back(field);
    for (const std::size_t field : coordinates_.fields) is_needed_[field] = true;
    if (coordinates_.invalid) is_needed_[*coordinates_.invalid] = true;
    for (const std::size_t from : chosen_)
      if (from >= 3) is_needed_[from - 3] = true;
  }

  /// `left`: bytes of the file that are in no section of a scan before.
  void read(std::uint64_t& left, RowPlace& place, const RowVisitor& visit) {
    pages_.seek(scan_.section);
    const auto kind = pages_.number<std::uint64_t>();
    const auto length = pages_.number<std::uint64_t>(), data = pages_.number<std::uint64_t>();
    if ((kind & 0xFF) != 1 || length > left)
      pages_.file().fail("a scan begins with no section of points, or it is longer than the file");
    left -= length;
    const std::uint64_t end = scan_.section + length;
    pages_.seek(pages_.withoutSums(data));
    for (std::uint64_t read = 0; read < scan_.points;) {
      if (pages_.position() >= end)
        pages_.file().fail("a scan of {} points ends after {}", scan_.points, read);
      readPacket(end);
      for (; read < scan_.points && hasNext(); ++read) visitNext(place, visit);
    }
  }

 private:
  void readPacket(std::uint64_t section_end) {
    const std::uint64_t begin = pages_.position();
    const auto type = pages_.number<std::uint8_t>();
    pages_.number<std::uint8_t>();  // flags
    const std::uint64_t end = begin + 1 + pages_.number<std::uint16_t>();
    if (type > 2 || (end - begin) % 4 != 0 || end > section_end)
      pages_.file().fail("a scan has a packet of type {} with {} bytes, which is none of E57", type,
                         end - begin);
    if (type == 1) readStreams(end);
    pages_.seek(end);
  }

  void readStreams(std::uint64_t packet_end) {
    const auto count = pages_.number<std::uint16_t>();
    if (count != streams_.size())
      pages_.file().fail("a packet has {} streams, its points have {} fields", count,
                         streams_.size());
    std::vector<std::uint16_t> bytes(count);
    pages_.read(bytes.data(), 2 * bytes.size());
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      if (pages_.position() + bytes[i] > packet_end)
        pages_.file().fail("a packet ends within its streams");
      if (is_needed_[i])
        streams_[i].append(pages_, bytes[i]);
      else
        pages_.seek(pages_.position() + bytes[i]);
    }
  }

  bool hasNext() const {
    for (std::size_t i = 0; i < streams_.size(); ++i)
      if (is_needed_[i] && !streams_[i].hasNext()) return false;
    return true;
  }

  void visitNext(RowPlace& place, const RowVisitor& visit) {
    fields_.resize(streams_.size());
    for (std::size_t i = 0; i < streams_.size(); ++i)
      if (is_needed_[i]) fields_[i] = streams_[i].next();
    Eigen::Vector3d p = scan_.T_file_scan * coordinates_.of(fields_);
    if (coordinates_.invalid && fields_[*coordinates_.invalid] != 0)
      p.setConstant(std::numeric_limits<double>::quiet_NaN());
    values_.clear();
    for (const std::size_t from : chosen_)
      values_.push_back(from < 3 ? p[static_cast<Eigen::Index>(from)] : fields_[from - 3]);
    visit(values_.data(), place);
    ++place.row;
  }

  E57Pages& pages_;
  const E57Scan& scan_;
  Coordinates coordinates_;
  std::vector<std::size_t> chosen_;
  std::vector<bool> is_needed_;  ///< by field
  std::vector<Bits> streams_;
  std::vector<double> fields_, values_;  ///< of the point at hand
};

bool isCoordinate(const std::string& name) {
  return name.rfind("cartesian", 0) == 0 || name.rfind("spherical", 0) == 0;
}

/// Its type has room for all that the field holds; scaled whole numbers are real.
ScalarType typeOf(const E57Field& field) {
  constexpr std::int64_t kLowest = -(std::int64_t{1} << 30);
  if (field.is_real && field.bits == 32) return ScalarType::f32;
  if (field.is_real || field.scale != 1 || field.offset != 0) return ScalarType::f64;
  if (field.minimum == 0 && field.bits <= 8) return ScalarType::u8;
  if (field.minimum == 0 && field.bits <= 16) return ScalarType::u16;
  if (field.minimum == 0 && field.bits <= 32) return ScalarType::u32;
  const bool is_short = field.minimum >= kLowest && field.minimum <= -kLowest && field.bits <= 30;
  return is_short ? ScalarType::i32 : ScalarType::i64;
}

}  // namespace

FileLayout readE57Header(InputFile& file) {
  const E57Pages pages(file);
  const E57Document document = readE57Document(pages);
  FileLayout layout;
  layout.format =
      fmt::format("E57, {} scan{}", document.scans.size(), document.scans.size() == 1 ? "" : "s");
  layout.encoding = Encoding::packets;
  layout.setups = document.scans.size();
  const auto hasFirstPose = [&](const E57Scan& scan) {
    return scan.T_file_scan.isApprox(document.scans[0].T_file_scan, 1e-9);
  };
  if (layout.setups > 1 && std::all_of(document.scans.begin(), document.scans.end(), hasFirstPose))
    layout.notes.push_back(fmt::format(
        "all {} setups have the same pose; if nobody has registered them: xview map --join {} "
        "MAP.xvm",
        layout.setups, pages.file().path()));
  layout.georeference = document.coordinates;
  layout.ends_with_rows = false;  // other sections and the XML follow
  Element points;
  points.name = "point";
  for (const char* axis : {"x", "y", "z"}) points.columns.push_back({axis, ScalarType::f64, 1, {}});
  for (const E57Field& field : document.scans[0].fields) {
    if (isCoordinate(field.name)) continue;
    points.columns.push_back({field.name, typeOf(field), 1, {}});
    Column& column = points.columns.back();
    bool is_of_all = true;
    for (const E57Scan& scan : document.scans) {
      const Slot there = findField(scan, field.name);
      is_of_all &= there.has_value();
      if (there && typeOf(scan.fields[*there]) != column.type) column.type = ScalarType::f64;
    }
    if (!is_of_all) layout.of_some_scans.push_back(field.name);
  }
  for (const E57Scan& scan : document.scans) {
    for (const E57Field& field : scan.fields) {
      std::vector<std::string>& some = layout.of_some_scans;
      if (!isCoordinate(field.name) && !findField(document.scans[0], field.name) &&
          std::find(some.begin(), some.end(), field.name) == some.end())
        some.push_back(field.name);
    }
  }
  for (const E57Scan& scan : document.scans) {
    Coordinates(scan, file);
    points.rows += scan.points;  // fewer than 2^64, as each file is longer than its points
  }
  layout.elements.push_back(std::move(points));
  return layout;
}

void readE57Rows(InputFile& file, const Element& points, const std::vector<std::size_t>& columns,
                 const RowVisitor& visit) {
  E57Pages pages(file);
  const E57Document document = readE57Document(pages);
  RowPlace place{file, points};
  std::uint64_t left = pages.size();
  for (const E57Scan& scan : document.scans) {
    std::vector<std::size_t> chosen;
    for (const std::size_t column : columns) {
      const std::string& name = points.columns[column].name;
      const Slot field = column < 3 ? Slot(column) : findField(scan, name);
      if (!field) file.fail("its scans differ: one has no field {}", inQuotes(name));
      chosen.push_back(column < 3 ? column : 3 + *field);
    }
    ScanReader(pages, scan, std::move(chosen)).read(left, place, visit);
  }
}

}  // namespace xview::io
