// SPDX-License-Identifier: BSD-3-Clause
// A document that names a file which is gone sends its reader nowhere.
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

}  // namespace
}  // namespace xview::test
