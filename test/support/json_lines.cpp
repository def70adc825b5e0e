// SPDX-License-Identifier: BSD-3-Clause
#include "support/json_lines.h"

#include <sstream>

namespace xview::test {

std::vector<Json> jsonLines(const std::string& text) {
  std::vector<Json> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(Json::parse(line));
  return lines;
}

std::string withoutTimes(const std::string& text) {
  std::string result;
  for (Json line : jsonLines(text)) {
    line.erase("timing_ms");
    result += line.dump() + "\n";
  }
  return result;
}

}  // namespace xview::test
