// SPDX-License-Identifier: BSD-3-Clause
#include "row_reader.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "pcd_compressed.h"
#include "xview/types/error.h"

namespace xview {
namespace {

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
    const std::size_t length = std::min(rest_.find_first_of(" \t"), rest_.size());
    const std::string_view word = rest_.substr(0, length);
    rest_.remove_prefix(length);
    skipBlanks();
    return parse(word);
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

  // Not strtod, whose decimal sign depends on the locale.
  double parse(std::string_view word) const {
    const bool plus = word.size() > 1 && word[0] == '+' && word[1] != '-';
    const char* first = word.data() + (plus ? 1 : 0);
    const char* last = word.data() + word.size();
    double value = 0;
    const auto [end, error] = std::from_chars(first, last, value);
    if (error == std::errc::result_out_of_range) place_.fail(quoted(word) + " is out of range");
    if (error != std::errc() || end != last) place_.fail(quoted(word) + " is not a number");
    return value;
  }

  std::string_view rest_;
  const RowPlace& place_;
};

/// A chosen value of an integer type must be one that the type can hold. Negative values of
/// unsigned types pass: -1 is a common way to say "none".
void requireFits(double value, const Column& column, const RowPlace& place) {
  if (!isInteger(column.type)) return;
  if (value != std::floor(value))
    place.fail("the value of " + quoted(column.name) + " is not a whole number");
  if (value > largestValue(column.type)) {
    place.fail("the value of " + quoted(column.name) + " does not fit its type, whose largest is " +
               std::to_string(static_cast<std::uint64_t>(largestValue(column.type))));
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
      file.failAtLine("the file ends after " + std::to_string(place.row) + " of " +
                      std::to_string(element.rows) + " rows of " + quoted(element.name));
    }
    readTextRow(line, slots, place, values);
    if (visit) visit(values.data(), place);
  }
}

/// Rows of one length, read in blocks.
void readFixedRows(InputFile& file, const Element& element, const std::vector<std::size_t>& columns,
                   bool big_endian, const RowVisitor& visit) {
  if (element.rows == 0) return;
  std::vector<std::size_t> offsets(element.columns.size() + 1, 0);
  for (std::size_t c = 0; c < element.columns.size(); ++c) {
    offsets[c + 1] = offsets[c] + element.columns[c].count * sizeOf(element.columns[c].type);
  }
  const std::size_t stride = offsets.back();
  const std::size_t block_rows = std::max<std::size_t>(1, (std::size_t{1} << 16) / stride);
  std::vector<char> block(
      static_cast<std::size_t>(std::min<std::uint64_t>(block_rows, element.rows)) * stride);
  std::vector<double> values(columns.size());
  RowPlace place{file, element};
  while (place.row < element.rows) {
    const auto rows =
        static_cast<std::size_t>(std::min<std::uint64_t>(block_rows, element.rows - place.row));
    file.readBytes(block.data(), rows * stride);
    if (!visit) {
      place.row += rows;
      continue;
    }
    for (std::size_t r = 0; r < rows; ++r, ++place.row) {
      for (std::size_t i = 0; i < columns.size(); ++i) {
        const char* bytes = block.data() + r * stride + offsets[columns[i]];
        values[i] = decodeScalar(bytes, element.columns[columns[i]].type, big_endian);
      }
      visit(values.data(), place);
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
      const ScalarType type = column.list_size.value_or(column.type);
      file.readBytes(bytes, sizeOf(type));
      const double value = decodeScalar(bytes, type, big_endian);
      if (column.list_size) skipValues(file, value, column.type, place);
      if (slots[c] != kSkipped) values[static_cast<std::size_t>(slots[c])] = value;
    }
    if (visit) visit(values.data(), place);
  }
}

}  // namespace

void RowPlace::fail(const std::string& what) const {
  if (text) file.failAtLine(what);
  file.fail(element.name + " " + std::to_string(row) + ": " + what);
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
    file.fail(std::to_string(excess) + " bytes more than the header announces, from byte " +
              std::to_string(begin));
  }
}

}  // namespace xview
