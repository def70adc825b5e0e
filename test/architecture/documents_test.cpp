// SPDX-License-Identifier: BSD-3-Clause
// A document that names a file which is gone sends its reader nowhere; long lines hide changes.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

#include "architecture/source_files.h"

namespace xview::test {
namespace {

namespace fs = std::filesystem;

/// Headers and sources that a page names in `backquotes`; wild cards are left out.
std::vector<std::string> filesNamedIn(const fs::path& page) {
  std::ifstream file(page);
  std::ostringstream text;
  text << file.rdbuf();
  const std::string content = text.str();
  static const std::regex named(R"(`((?:[\w.]+/)*\w+\.(?:h|cpp))`)");
  std::vector<std::string> names;
  for (std::sregex_iterator at(content.begin(), content.end(), named), end; at != end; ++at)
    names.push_back((*at)[1]);
  return names;
}

bool endsWith(const std::string& path, const std::string& end) {
  return path.size() >= end.size() && path.compare(path.size() - end.size(), end.size(), end) == 0;
}

TEST(Documents, NameFilesThatExist) {
  std::vector<std::string> paths;
  for (const SourceFile& file : sourceFiles()) paths.push_back(file.path.generic_string());
  std::size_t named = 0;
  const fs::path root = XVIEW_SOURCE_DIR;
  for (const fs::path& folder : {root, root / "docs"}) {
    for (const fs::directory_entry& page : fs::directory_iterator(folder)) {
      if (page.path().extension() != ".md" || page.path().filename() == "CHANGELOG.md") continue;
      for (const std::string& name : filesNamedIn(page.path())) {
        ++named;
        const auto isIt = [&](const std::string& path) { return endsWith(path, "/" + name); };
        EXPECT_TRUE(std::any_of(paths.begin(), paths.end(), isIt) || fs::exists(root / name))
            << page.path().filename() << " names " << name;
      }
    }
  }
  EXPECT_GT(named, 40u);
}

/// Characters of a line of UTF-8.
std::size_t charactersOf(const std::string& line) {
  const auto isFirst = [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; };
  return static_cast<std::size_t>(std::count_if(line.begin(), line.end(), isFirst));
}

TEST(Documents, HaveShortLinesOutsideOfTables) {
  std::size_t pages = 0;
  const fs::path root = XVIEW_SOURCE_DIR;
  for (const fs::path& folder : {root, root / "docs", root / "docs/results"}) {
    for (const fs::directory_entry& page : fs::directory_iterator(folder)) {
      if (page.path().extension() != ".md") continue;
      ++pages;
      std::ifstream file(page.path());
      int number = 1;
      for (std::string line; std::getline(file, line); ++number) {
        const bool is_of_table = !line.empty() && line[0] == '|';
        EXPECT_TRUE(is_of_table || charactersOf(line) <= 120) << page.path() << ":" << number;
      }
    }
  }
  EXPECT_GT(pages, 12u);
}

/// Paths of headers and sources that the comments of a header name, but for those of libraries.
std::vector<std::string> filesNamedInCommentsOf(const SourceFile& header) {
  static const std::regex named(R"((<?)((?:\w+/)*\w+\.(?:h|cpp))\b)");
  std::vector<std::string> names;
  std::istringstream lines(header.text);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t comment = line.find("//");
    if (comment == std::string::npos) continue;
    line = line.substr(comment);
    for (std::sregex_iterator at(line.begin(), line.end(), named), end; at != end; ++at) {
      const bool is_of_library = (*at)[1].length() > 0 && (*at)[2].str().rfind("xview/", 0) != 0;
      if (!is_of_library) names.push_back((*at)[2]);
    }
  }
  return names;
}

TEST(PublicHeaders, NameFilesThatExist) {
  std::vector<std::string> paths;
  for (const SourceFile& file : sourceFiles()) paths.push_back(file.path.generic_string());
  std::size_t named = 0;
  for (const SourceFile& header : sourceFiles()) {
    if (header.path.string().rfind(XVIEW_SOURCE_DIR "/include/", 0) != 0) continue;
    for (const std::string& name : filesNamedInCommentsOf(header)) {
      ++named;
      const auto isIt = [&](const std::string& path) { return endsWith(path, "/" + name); };
      EXPECT_TRUE(std::any_of(paths.begin(), paths.end(), isIt))
          << header.path.string() << " names " << name;
    }
  }
  EXPECT_GT(named, 5u);
}

}  // namespace
}  // namespace xview::test
