// SPDX-License-Identifier: BSD-3-Clause
#include "element_table.h"

#include <algorithm>
#include <cstring>
#include <limits>

namespace xview {
namespace {

constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();

std::uint64_t saturatingProduct(std::uint64_t a, std::uint64_t b) {
  std::uint64_t product = 0;
  return __builtin_mul_overflow(a, b, &product) ? kMost : product;
}

std::uint64_t saturatingSum(std::uint64_t a, std::uint64_t b) {
  std::uint64_t sum = 0;
  return __builtin_add_overflow(a, b, &sum) ? kMost : sum;
}

template <class T>
double decodeAs(const char* bytes, bool big_endian) {
  char ordered[sizeof(T)];
  std::memcpy(ordered, bytes, sizeof(T));
  if (big_endian) std::reverse(ordered, ordered + sizeof(T));
  T value;
  std::memcpy(&value, ordered, sizeof(T));
  return static_cast<double>(value);
}

/// The least a row can need: in text one digit and a separator, so that a row that is too short is
/// found by its line; in binary files empty lists.
std::uint64_t leastRowBytes(const Element& element, Encoding encoding) {
  return encoding == Encoding::ascii ? 2 : rowBytes(element);
}

std::string bytesText(std::uint64_t bytes) {
  return bytes == kMost ? "more than 2^64 bytes" : std::to_string(bytes) + " bytes";
}

}  // namespace

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "binary files are read by copying bytes");

std::size_t sizeOf(ScalarType type) {
  switch (type) {
    case ScalarType::i8:
    case ScalarType::u8:
      return 1;
    case ScalarType::i16:
    case ScalarType::u16:
      return 2;
    case ScalarType::i32:
    case ScalarType::u32:
    case ScalarType::f32:
      return 4;
    case ScalarType::i64:
    case ScalarType::u64:
    case ScalarType::f64:
      return 8;
  }
  return 0;
}

bool isInteger(ScalarType type) { return type != ScalarType::f32 && type != ScalarType::f64; }

double largestValue(ScalarType type) {
  switch (type) {
    case ScalarType::i8:
      return std::numeric_limits<std::int8_t>::max();
    case ScalarType::u8:
      return std::numeric_limits<std::uint8_t>::max();
    case ScalarType::i16:
      return std::numeric_limits<std::int16_t>::max();
    case ScalarType::u16:
      return std::numeric_limits<std::uint16_t>::max();
    case ScalarType::i32:
      return std::numeric_limits<std::int32_t>::max();
    case ScalarType::u32:
      return std::numeric_limits<std::uint32_t>::max();
    case ScalarType::i64:
      return 0x1p63;
    case ScalarType::u64:
      return 0x1p64;
    case ScalarType::f32:
    case ScalarType::f64:
      break;
  }
  return std::numeric_limits<double>::infinity();
}

double decodeScalar(const char* bytes, ScalarType type, bool big_endian) {
  switch (type) {
    case ScalarType::i8:
      return decodeAs<std::int8_t>(bytes, big_endian);
    case ScalarType::u8:
      return decodeAs<std::uint8_t>(bytes, big_endian);
    case ScalarType::i16:
      return decodeAs<std::int16_t>(bytes, big_endian);
    case ScalarType::u16:
      return decodeAs<std::uint16_t>(bytes, big_endian);
    case ScalarType::i32:
      return decodeAs<std::int32_t>(bytes, big_endian);
    case ScalarType::u32:
      return decodeAs<std::uint32_t>(bytes, big_endian);
    case ScalarType::i64:
      return decodeAs<std::int64_t>(bytes, big_endian);
    case ScalarType::u64:
      return decodeAs<std::uint64_t>(bytes, big_endian);
    case ScalarType::f32:
      return decodeAs<float>(bytes, big_endian);
    case ScalarType::f64:
      return decodeAs<double>(bytes, big_endian);
  }
  return 0;
}

bool Element::hasLists() const {
  return std::any_of(columns.begin(), columns.end(),
                     [](const Column& column) { return column.list_size.has_value(); });
}

std::optional<std::size_t> Element::findColumn(const std::string& column,
                                               const InputFile& file) const {
  std::optional<std::size_t> found;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i].name != column) continue;
    if (found) file.fail("the field " + quoted(column) + " appears twice in the header");
    found = i;
  }
  return found;
}

std::string Element::columnNames() const {
  constexpr std::size_t kLongest = 200;
  std::string names;
  for (const Column& column : columns) {
    const std::string printable = quoted(column.name);
    names += (names.empty() ? "" : " ") + printable.substr(1, printable.size() - 2);
    if (names.size() > kLongest) return names + " ...";
  }
  return names;
}

const Element* FileLayout::findElement(const std::string& name) const {
  for (const Element& element : elements) {
    if (element.name == name) return &element;
  }
  return nullptr;
}

std::uint64_t rowBytes(const Element& element) {
  std::uint64_t bytes = 0;
  for (const Column& column : element.columns) {
    const std::size_t value_bytes = sizeOf(column.list_size.value_or(column.type));
    const std::uint64_t values = column.list_size ? 1 : column.count;
    bytes = saturatingSum(bytes, saturatingProduct(values, value_bytes));
  }
  return bytes;
}

void checkSize(const InputFile& file, const FileLayout& layout) {
  if (layout.encoding == Encoding::compressed) return;  // the block has sizes of its own
  // The last line of a text needs no separator.
  const std::uint64_t available = file.remaining() + (layout.encoding == Encoding::ascii ? 1 : 0);
  std::uint64_t needed = 0;
  for (const Element& element : layout.elements) {
    needed = saturatingSum(
        needed, saturatingProduct(element.rows, leastRowBytes(element, layout.encoding)));
    if (needed > available) {
      file.fail("is too short for its header: expected " + std::to_string(element.rows) +
                " rows of " + quoted(element.name) + ", which need at least " + bytesText(needed) +
                ", found " + bytesText(file.remaining()));
    }
  }
}

}  // namespace xview
