// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "element_table.h"

namespace xview {

/// Where a row stands, for messages: "path:line: what" in text, "path: point 17: what" in binary
/// files (points from 0).
struct RowPlace {
  const InputFile& file;
  const Element& element;
  bool text = false;
  std::uint64_t row = 0;

  [[noreturn]] void fail(const std::string& what) const;
};

/// Is called for every row with the values of the chosen columns, in the order of the choice.
using RowVisitor = std::function<void(const double* values, const RowPlace& place)>;

/// Reads the rows of one element; the file stands at the first and is left behind the last. The
/// chosen columns must be no lists and have one value per row; everything else is skipped (in text:
/// must be numbers). Throws Error.
void readRows(InputFile& file, const FileLayout& layout, const Element& element,
              const std::vector<std::size_t>& columns, const RowVisitor& visit);

/// Throws Error if something other than blanks, blank lines or a little padding with zeros follows
/// the last row.
void requireEnd(InputFile& file, const FileLayout& layout);

}  // namespace xview
