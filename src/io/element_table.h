// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "input_file.h"

namespace xview {

// What the headers of PCD and PLY files say, in one form: elements (points, vertices, edges), each
// a table of typed columns.

enum class ScalarType { i8, u8, i16, u16, i32, u32, i64, u64, f32, f64 };

std::size_t sizeOf(ScalarType type);
bool isInteger(ScalarType type);
double largestValue(ScalarType type);  ///< of an integer type, as the nearest double
/// The number at `bytes`. Integers beyond 2^53 are rounded, which no coordinate and no id can
/// notice.
double decodeScalar(const char* bytes, ScalarType type, bool big_endian);

struct Column {
  std::string name;
  ScalarType type = ScalarType::f32;
  std::uint64_t count = 1;  ///< values per row; for a list its length stands in the data
  std::optional<ScalarType> list_size;  ///< type of the length, if the column is a list
};

struct Element {
  std::string name;  ///< "point" for PCD
  std::uint64_t rows = 0;
  std::vector<Column> columns;

  bool hasLists() const;
  /// Position of the only column of that name; none if there is none. Two of that name are an error
  /// of the file.
  std::optional<std::size_t> findColumn(const std::string& column, const InputFile& file) const;
  std::string columnNames() const;  ///< "x y z label", for messages
};

enum class Encoding { ascii, little_endian, big_endian, compressed };

/// A parsed header; the file stands at the first byte of the body.
struct FileLayout {
  std::string format;  ///< "PCD ascii", "PLY binary_little_endian", …
  Encoding encoding = Encoding::ascii;
  std::vector<Element> elements;
  std::vector<std::string> comments;  ///< of the header, words joined by one blank

  const Element* findElement(const std::string& name) const;
};

/// Bytes of a row in a binary file if its lists are empty; saturates at 2^64-1.
std::uint64_t rowBytes(const Element& element);

/// Throws Error if the rest of the file cannot hold the rows that the header announces. In 64 bit
/// and before anything is allocated, so that a header of 200 bytes cannot demand gigabytes.
void checkSize(const InputFile& file, const FileLayout& layout);

}  // namespace xview
