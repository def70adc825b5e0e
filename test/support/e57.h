// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace xview::test {

// A writer of E57 files, from the tables of ASTM E2807 and not by the library.

struct E57Column {
  std::string name;
  std::string attributes;  ///< of its element in the prototype
  int bits = 64;
  bool is_real = true;
  std::int64_t minimum = 0;
};
E57Column e57Real(const std::string& name, int bits);
/// As many bits as its range takes; values are the stored whole numbers.
E57Column e57Whole(const std::string& name, std::int64_t minimum, std::int64_t maximum,
                   const std::string& scale = "");

struct E57Points {
  std::vector<E57Column> columns;
  std::vector<std::vector<double>> rows;
  std::string pose;         ///< XML
  std::size_t packets = 1;  ///< that the bytes are spread over
  bool has_index = false;   ///< with packets of other types between
};

/// A file without the sums of its pages, its texts changed where `from` stands.
std::string e57Content(const std::vector<E57Points>& scans, const std::string& from = "",
                       const std::string& to = "");
/// The same bytes in pages with sums, their number in the header.
std::string e57Paged(std::string content);

}  // namespace xview::test
