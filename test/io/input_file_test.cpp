// SPDX-License-Identifier: BSD-3-Clause
#include "io/input_file.h"

#include <gtest/gtest.h>

#include <sstream>

#include "support/test_data.h"
#include "xview/base/error.h"

namespace xview::io {
namespace {

using test::messageOf;
using test::writeText;

std::vector<std::string> linesOf(const std::string& path) {
  InputFile file(path);
  std::vector<std::string> lines;
  for (std::string_view line; file.readLine(line);) lines.emplace_back(line);
  EXPECT_EQ(file.lineNumber(), lines.size());
  EXPECT_EQ(file.position(), file.size());
  return lines;
}

TEST(InputFile, LinesOfEveryLengthAreThoseOfTheStandardLibrary) {
  const test::TemporaryFolder folder;
  std::string text;
  for (const int length : {0, 1, 4094, 4095, 4096, 4097, 0, 8191, 8192, 8193, 3, 1 << 20, 5})
    text += std::string(static_cast<std::size_t>(length), static_cast<char>('a' + length % 26)) +
            (length % 2 == 0 ? "\n" : "\r\n");
  for (const std::string& end : {std::string(), std::string("last"), std::string(4096, 'z')}) {
    writeText(folder / "lines.txt", text + end);
    std::vector<std::string> expected;
    std::istringstream stream(text + end);
    for (std::string line; std::getline(stream, line);) {
      if (!line.empty() && line.back() == '\r') line.pop_back();
      expected.push_back(line);
    }
    EXPECT_EQ(linesOf(folder / "lines.txt"), expected) << end.size();
  }
}

TEST(InputFile, LongerThanTheLongestLineIsAnErrorOfThatLine) {
  const test::TemporaryFolder folder;
  const std::string path = folder / "lines.txt", longest(1 << 20, 'x');
  writeText(path, "first\n" + longest + "\n" + longest + "y\nlast\n");
  EXPECT_EQ(messageOf<Error>([&] { linesOf(path); }), path + ":3: the line is longer than 1 MiB");
}

}  // namespace
}  // namespace xview::io
