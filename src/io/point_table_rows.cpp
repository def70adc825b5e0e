// SPDX-License-Identifier: BSD-3-Clause
// The rows of PCD and PLY files in all their encodings, and what their columns mean.
#include <strings.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/user_text.h"
#include "point_table.h"

namespace xview::io {
namespace {

template <class T>
double decodeAs(const char* bytes, bool big_endian) {
  return static_cast<double>(storedNumber<T>(bytes, big_endian));
}

using Decode = double (*)(const char* bytes, bool big_endian);

struct TypeTraits {
  std::size_t size;
  double largest;  ///< the nearest double
  Decode decode;
};

template <class T>
constexpr TypeTraits traitsOf() {
  return {sizeof(T), static_cast<double>(std::numeric_limits<T>::max()), decodeAs<T>};
}

const TypeTraits& traitsOf(ScalarType type) {
  static constexpr TypeTraits kTypes[] = {traitsOf<std::int8_t>(),  traitsOf<std::uint8_t>(),
                                          traitsOf<std::int16_t>(), traitsOf<std::uint16_t>(),
                                          traitsOf<std::int32_t>(), traitsOf<std::uint32_t>(),
                                          traitsOf<std::int64_t>(), traitsOf<std::uint64_t>(),
                                          traitsOf<float>(),        traitsOf<double>()};
  return kTypes[static_cast<std::size_t>(type)];
}

// ---- text

constexpr int kSkipped = -1;

/// For each column of the element, its place in the choice or kSkipped.
std::vector<int> slotsOf(const Element& element, const std::vector<std::size_t>& columns) {
  std::vector<int> slots(element.columns.size(), kSkipped);
  for (std::size_t i = 0; i < columns.size(); ++i) slots[columns[i]] = static_cast<int>(i);
  return slots;
}

/// The words of a text row, which must all be numbers.
class TextRow {
 public:
  TextRow(std::string_view line, const RowPlace& place) : rest_(line), place_(place) {
    skipBlanks();
  }

  bool atEnd() const { return rest_.empty(); }

  double number() {
    if (atEnd()) place_.fail("too few values, expected " + place_.element.columnNames());
    const std::string_view word = rest_.substr(0, rest_.find_first_of(" \t"));
    rest_.remove_prefix(word.size());
    skipBlanks();
    std::errc problem{};
    const std::optional<double> value = numberFrom<double>(word, &problem);
    if (value) return *value;
    const bool too_large = problem == std::errc::result_out_of_range;
    place_.fail(inQuotes(word) + (too_large ? " is out of range" : " is not a number"));
  }

  std::uint64_t listLength() {
    const double length = number();
    if (!(length >= 0 && length <= 0x1p32 && length == std::floor(length))) {
      place_.fail("the length of a list must be a whole number >= 0");
    }
    return static_cast<std::uint64_t>(length);
  }

 private:
  void skipBlanks() { rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t"), rest_.size())); }

  std::string_view rest_;
  const RowPlace& place_;
};

/// A chosen value of an integer type must be one that the type can hold. Negative values of
/// unsigned types pass: -1 is a common way to say "none".
void requireFits(double value, const Column& column, const RowPlace& place) {
  if (!isInteger(column.type)) return;
  if (value != std::floor(value))
    place.fail("the value of {} is not a whole number", inQuotes(column.name));
  const double largest = traitsOf(column.type).largest;
  if (value > largest) {
    place.fail("the value of {} does not fit its type, whose largest is {}", inQuotes(column.name),
               static_cast<std::uint64_t>(largest));
  }
}

void readTextRow(std::string_view line, const std::vector<int>& slots, const RowPlace& place,
                 std::vector<double>& values) {
  TextRow row(line, place);
  if (row.atEnd()) place.fail("an empty line, expected " + place.element.columnNames());
  for (std::size_t c = 0; c < slots.size(); ++c) {
    const Column& column = place.element.columns[c];
    const std::uint64_t count = column.list_size ? row.listLength() : column.count;
    for (std::uint64_t k = 0; k < count; ++k) {
      const double value = row.number();
      if (slots[c] == kSkipped) continue;
      requireFits(value, column, place);
      values[static_cast<std::size_t>(slots[c])] = value;
    }
  }
  if (!row.atEnd()) place.fail("too many values, expected " + place.element.columnNames());
}

void readTextRows(InputFile& file, const Element& element, const std::vector<std::size_t>& columns,
                  const RowVisitor& visit) {
  const std::vector<int> slots = slotsOf(element, columns);
  std::vector<double> values(columns.size());
  RowPlace place{file, element, true};
  std::string_view line;
  for (; place.row < element.rows; ++place.row) {
    if (!file.readLine(line)) {
      file.failAtLine("the file ends after {} of {} rows of {}", place.row, element.rows,
                      inQuotes(element.name));
    }
    readTextRow(line, slots, place, values);
    if (visit) visit(values.data(), place);
  }
}

// ---- bytes

/// Where the values of a chosen column stand in successive rows.
struct ColumnBytes {
  const char* next;
  std::size_t stride;
  Decode decode;
};

void visitRows(std::vector<ColumnBytes> columns, std::uint64_t rows, bool big_endian,
               RowPlace& place, const RowVisitor& visit) {
  std::vector<double> values(columns.size());
  for (std::uint64_t end = place.row + rows; place.row < end; ++place.row) {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      values[i] = columns[i].decode(columns[i].next, big_endian);
      columns[i].next += columns[i].stride;
    }
    visit(values.data(), place);
  }
}

/// Rows of one length, read in blocks: large clouds are read in 0.6 of the time that values one by
/// one take.
void readFixedRows(InputFile& file, const Element& element, const std::vector<std::size_t>& columns,
                   bool big_endian, const RowVisitor& visit) {
  if (element.rows == 0) return;
  const std::size_t stride = element.rowBytes();
  const std::uint64_t block_rows = std::max<std::size_t>(1, (std::size_t{1} << 16) / stride);
  std::vector<char> block(std::min(block_rows, element.rows) * stride);
  std::vector<std::size_t> offsets(1, 0);
  for (const Column& column : element.columns) {
    offsets.push_back(offsets.back() + column.count * sizeOf(column.type));
  }
  std::vector<ColumnBytes> views;
  for (const std::size_t c : columns) {
    views.push_back({block.data() + offsets[c], stride, traitsOf(element.columns[c].type).decode});
  }
  RowPlace place{file, element};
  while (place.row < element.rows) {
    const std::uint64_t rows = std::min(block_rows, element.rows - place.row);
    file.readBytes(block.data(), rows * stride);
    if (visit) {
      visitRows(views, rows, big_endian, place, visit);
    } else {
      place.row += rows;
    }
  }
}

/// Reads over `count` values; bounded by the file, so that a length that lies cannot take long.
void skipValues(InputFile& file, double count, ScalarType type, const RowPlace& place) {
  const double bytes = count * static_cast<double>(sizeOf(type));
  if (!(count >= 0 && bytes <= static_cast<double>(file.remaining()))) {
    place.fail("a list with a length that the file cannot hold");
  }
  char ignored[4096];
  for (auto left = static_cast<std::size_t>(bytes); left > 0;) {
    const std::size_t part = std::min(left, sizeof(ignored));
    file.readBytes(ignored, part);
    left -= part;
  }
}

/// Rows with lists have no fixed length and are read value by value.
void readListRows(InputFile& file, const Element& element, const std::vector<std::size_t>& columns,
                  bool big_endian, const RowVisitor& visit) {
  const std::vector<int> slots = slotsOf(element, columns);
  std::vector<double> values(columns.size());
  RowPlace place{file, element};
  char bytes[8];
  for (; place.row < element.rows; ++place.row) {
    for (std::size_t c = 0; c < slots.size(); ++c) {
      const Column& column = element.columns[c];
      const TypeTraits& type = traitsOf(column.list_size.value_or(column.type));
      file.readBytes(bytes, type.size);
      const double value = type.decode(bytes, big_endian);
      if (column.list_size) skipValues(file, value, column.type, place);
      if (slots[c] != kSkipped) values[static_cast<std::size_t>(slots[c])] = value;
    }
    if (visit) visit(values.data(), place);
  }
}

// ---- PCD binary_compressed: two sizes and one LZF block, in which the values of each field stand
// together

/// No LZF stream expands more: three bytes give at most 264.
constexpr std::size_t kLargestLzfExpansion = 88;

/// Undoes LZF: true if the input was used up and filled the output exactly; never reads or writes
/// outside. Ours, because PCL's lzfDecompress lies in libpcl_io, which loads all of VTK.
/// The stream is a sequence of two kinds of items, told apart by their first byte:
///   000LLLLL                       L + 1 bytes follow as they are
///   LLLooooo [llllllll] oooooooo   copy L + 2 bytes from o + 1 bytes back; L = 7 means 7 + l
bool decompressLzf(const std::vector<unsigned char>& packed, std::vector<char>& output) {
  const unsigned char *input = packed.data(), *const end = input + packed.size();
  std::size_t done = 0;
  while (input < end) {
    const std::size_t control = *input++;
    if (control < 32) {
      const std::size_t length = control + 1;
      if (length > static_cast<std::size_t>(end - input) || length > output.size() - done)
        return false;
      std::memcpy(output.data() + done, input, length);
      input += length;
      done += length;
      continue;
    }
    std::size_t length = control >> 5;
    if (length == 7) {
      if (input == end) return false;
      length += *input++;
    }
    length += 2;
    if (input == end) return false;
    const std::size_t distance = ((control & 31) << 8) + *input++ + 1;
    if (distance > done || length > output.size() - done) return false;
    // Byte by byte: the source may overlap what is being written.
    for (std::size_t i = 0; i < length; ++i, ++done) output[done] = output[done - distance];
  }
  return done == output.size();
}

/// Reads and unpacks the block; all sizes are checked before memory is taken for them.
std::vector<char> readCompressedBlock(InputFile& file, const Element& element) {
  std::uint32_t sizes[2] = {};  // packed, unpacked
  if (file.remaining() < sizeof(sizes)) file.fail("ends before the sizes of the compressed block");
  file.readBytes(sizes, sizeof(sizes));
  std::uint64_t expected = 0;
  const std::uint64_t row_bytes = element.rowBytes();
  if (__builtin_mul_overflow(element.rows, row_bytes, &expected) || sizes[1] != expected) {
    file.fail("the compressed block unpacks to {} bytes, expected {} points of {} bytes", sizes[1],
              element.rows, row_bytes);
  }
  if (sizes[0] > file.remaining()) {
    file.fail("the compressed block has {} bytes, but only {} follow", sizes[0], file.remaining());
  }
  if (sizes[1] / kLargestLzfExpansion > sizes[0]) {
    file.fail("{} compressed bytes cannot unpack to {}", sizes[0], sizes[1]);
  }
  std::vector<unsigned char> packed(sizes[0]);
  std::vector<char> unpacked(sizes[1]);
  file.readBytes(packed.data(), packed.size());
  if (!decompressLzf(packed, unpacked)) file.fail("the compressed block is damaged");
  return unpacked;
}

void readCompressedRows(InputFile& file, const Element& element,
                        const std::vector<std::size_t>& columns, const RowVisitor& visit) {
  if (element.rows == 0) return;
  const std::vector<char> block = readCompressedBlock(file, element);
  std::vector<const char*> begins(1, block.data());
  for (const Column& column : element.columns) {
    begins.push_back(begins.back() + element.rows * column.count * sizeOf(column.type));
  }
  std::vector<ColumnBytes> views;
  for (const std::size_t c : columns) {
    const TypeTraits& type = traitsOf(element.columns[c].type);
    views.push_back({begins[c], type.size, type.decode});
  }
  RowPlace place{file, element};
  visitRows(views, element.rows, false, place, visit);
}

// ---- meaning of the columns

constexpr const char* kLabelNames[] = {"label",
                                       "class",
                                       "semantic",
                                       "sem_label",
                                       "scalar_Label",
                                       "scalar_label",
                                       "scalar_Classification",
                                       "classification",
                                       "scalar_Class",
                                       "ObjTag"};
constexpr const char* kInstanceNames[] = {"instance",        "object",        "ins_label",
                                          "scalar_Instance", "scalar_Object", "ObjIdx"};

constexpr const char* kSigmaNames[] = {"sigma", "scalar_sigma"};

template <std::size_t N>
std::optional<std::size_t> findFirst(const Element& points, const std::string& asked,
                                     const char* const (&well_known)[N], const InputFile& file) {
  if (!asked.empty()) {
    const auto column = points.findColumn(asked, file);
    if (!column)
      file.fail("has no field {}; its fields: {}", inQuotes(asked), points.columnNames());
    return column;
  }
  for (const char* name : well_known) {
    if (const auto column = points.findColumn(name, file)) return column;
  }
  return std::nullopt;
}

}  // namespace

std::size_t sizeOf(ScalarType type) { return traitsOf(type).size; }

void RowPlace::fail(const std::string& what) const {
  if (text) file.failAtLine(what);
  file.fail("{} {}: {}", element.name, row, what);
}

void readRows(InputFile& file, const FileLayout& layout, const Element& element,
              const std::vector<std::size_t>& columns, const RowVisitor& visit) {
  const bool big_endian = layout.encoding == Encoding::big_endian;
  if (layout.encoding == Encoding::ascii) {
    readTextRows(file, element, columns, visit);
  } else if (layout.encoding == Encoding::compressed) {
    readCompressedRows(file, element, columns, visit);
  } else if (element.hasLists()) {
    readListRows(file, element, columns, big_endian, visit);
  } else {
    readFixedRows(file, element, columns, big_endian, visit);
  }
}

void readStoredRows(const InputFile& file, const Element& element, const StoredRows& rows,
                    const std::vector<std::size_t>& columns, const RowVisitor& visit) {
  RowPlace place{file, element};
  for (const char* line = rows.bytes; place.row < element.rows; line += rows.line_bytes) {
    std::vector<ColumnBytes> views;
    for (const std::size_t c : columns) {
      views.push_back({line + rows.offsets[c], static_cast<std::size_t>(rows.row_bytes),
                       traitsOf(element.columns[c].type).decode});
    }
    visitRows(views, std::min(rows.line_rows, element.rows - place.row), rows.big_endian, place,
              visit);
  }
}

void readTable(InputFile& file, const FileLayout& layout, const Element& table,
               const std::vector<std::size_t>& columns, const RowVisitor& visit) {
  if (layout.encoding == Encoding::packets) return readE57Rows(file, table, columns, visit);
  for (const Element& element : layout.elements) {
    if (&element == &table)
      readRows(file, layout, element, columns, visit);
    else
      readRows(file, layout, element, {}, nullptr);
  }
}

void requireEnd(InputFile& file, const FileLayout& layout) {
  const auto isBlank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; };
  if (layout.encoding == Encoding::ascii) {
    std::string_view line;
    while (file.readLine(line)) {
      if (!std::all_of(line.begin(), line.end(), isBlank))
        file.failAtLine("more lines than the header announces");
    }
    return;
  }
  // Old versions of PCL filled binary files up with zeros to the next page.
  constexpr std::uint64_t kLongestPadding = std::uint64_t{1} << 16;
  const std::uint64_t begin = file.position(), excess = file.remaining();
  std::vector<char> rest(static_cast<std::size_t>(std::min(excess, kLongestPadding)));
  file.readBytes(rest.data(), rest.size());
  const bool padding =
      excess <= kLongestPadding &&
      std::all_of(rest.begin(), rest.end(), [&](char c) { return c == '\0' || isBlank(c); });
  if (!padding) {
    file.fail("{} bytes more than the header announces, from byte {}", excess, begin);
  }
}

IdColumns findIdColumns(const Element& points, const CloudFields& fields, const InputFile& file) {
  IdColumns columns;
  columns.label = findFirst(points, fields.label, kLabelNames, file);
  columns.instance = findFirst(points, fields.instance, kInstanceNames, file);
  if (columns.label && columns.label == columns.instance) {
    file.fail("the field {} cannot be label and instance at once", inQuotes(fields.label));
  }
  return columns;
}

bool namesId(const std::string& name) {
  const auto is = [&](const char* known) { return strcasecmp(name.c_str(), known) == 0; };
  return std::any_of(std::begin(kLabelNames), std::end(kLabelNames), is) ||
         std::any_of(std::begin(kInstanceNames), std::end(kInstanceNames), is);
}

std::optional<std::size_t> findSigmaColumn(const Element& points, const InputFile& file) {
  return findFirst(points, {}, kSigmaNames, file);
}

ChosenColumns::ChosenColumns(const Element& points, const InputFile& file) : element_(points) {
  for (const auto& [axis, upper] :
       {std::pair("x", "X"), std::pair("y", "Y"), std::pair("z", "Z")}) {
    auto column = points.findColumn(axis, file);
    if (!column) column = points.findColumn(upper, file);
    if (!column) file.fail("has no field {}; its fields: {}", axis, points.columnNames());
    columns_.push_back(*column);
  }
}

ChosenColumns::Slot ChosenColumns::add(const std::optional<std::size_t>& column) {
  if (!column) return std::nullopt;
  columns_.push_back(*column);
  return columns_.size() - 1;
}

std::uint32_t ChosenColumns::id(const Slot& slot, const double* values, const RowPlace& place,
                                std::uint32_t absent) const {
  constexpr double kMinusOne32 = 4294967295.0;
  constexpr double kMinusOne64 = 0x1p64;  // 2^64 - 1 as a double
  if (!slot) return absent;
  constexpr double kRounded = 1e-3;  // what float32 and text make of a whole number
  double value = values[*slot];
  const Column& source = column(*slot);
  if (std::isnan(value)) return 0;
  if (std::abs(value - std::round(value)) <= kRounded) value = std::round(value);
  if (value == kMinusOne32 || (value == kMinusOne64 && source.type == ScalarType::u64)) return 0;
  const bool whole = std::isfinite(value) && value == std::floor(value);
  if (whole && value < 0) return 0;
  if (!whole || value > kMinusOne32) {
    place.fail("{} must be a whole number below 2^32, found {}", inQuotes(source.name),
               numberText(value));
  }
  return static_cast<std::uint32_t>(value);
}

float ChosenColumns::sigma(const Slot& slot, const double* values, const RowPlace& place) const {
  if (!slot) return 0;
  const double value = values[*slot];
  if (std::isfinite(value) && value >= 0) return static_cast<float>(value);
  place.fail(
      "{} must be the standard deviation of the position in metres, >= 0, found {}; rename or "
      "remove the field if it is something else",
      inQuotes(column(*slot).name), numberText(value));
}

}  // namespace xview::io
