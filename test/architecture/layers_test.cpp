// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

/// A place in include/xview or src, by its first folder; the two pipelines and the options are
/// places of their own.
std::string placeOf(const fs::path& relative) {
  const std::string first = relative.begin()->string();
  if (first == "options.h" || first == "options_file.h") return "options";
  return relative.has_parent_path() ? first : "pipeline";
}

/// Which places each place may include; itself is always allowed. See docs/architecture.md.
std::map<std::string, std::set<std::string>> allowed() {
  std::map<std::string, std::set<std::string>> table;
  table["types"] = {};
  const std::set<std::string> stages{"graph", "match", "verify", "pose", "io", "sim", "eval"};
  for (const std::string& stage : stages) table[stage] = {"types"};
  std::set<std::string> computing = stages;
  for (const char* rim : {"io", "sim", "eval"}) computing.erase(rim);
  computing.insert("types");
  table["options"] = computing;
  table["map"] = computing;
  table["pipeline"] = computing;
  table["pipeline"].insert({"options", "map"});
  table["view"] = table["pipeline"];
  return table;
}

struct Inclusion {
  std::string file, place, target;
};

std::vector<Inclusion> inclusionsUnder(const fs::path& root) {
  const std::regex include(R"(^\s*#\s*include\s*[<"]xview/([^">]+)[">])");
  std::vector<Inclusion> found;
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    const std::string ending = entry.path().extension().string();
    if (ending != ".h" && ending != ".cpp") continue;
    std::ifstream file(entry.path());
    std::string line;
    std::smatch match;
    while (std::getline(file, line)) {
      if (!std::regex_search(line, match, include)) continue;
      found.push_back({entry.path().string(), placeOf(fs::relative(entry.path(), root)),
                       placeOf(match[1].str())});
    }
  }
  return found;
}

class Layers : public testing::TestWithParam<const char*> {};

TEST_P(Layers, IncludeOnlyWhatIsBelowThem) {
  const auto table = allowed();
  const auto inclusions = inclusionsUnder(fs::path(XVIEW_SOURCE_DIR) / GetParam());
  ASSERT_FALSE(inclusions.empty());
  for (const Inclusion& inclusion : inclusions) {
    if (inclusion.place == inclusion.target) continue;
    const auto row = table.find(inclusion.place);
    ASSERT_NE(row, table.end()) << inclusion.file
                                << " is in a folder that has no row in the table of layers";
    EXPECT_TRUE(row->second.count(inclusion.target))
        << inclusion.file << ": " << inclusion.place << " may not include " << inclusion.target;
  }
}

INSTANTIATE_TEST_SUITE_P(Headers, Layers, testing::Values("include/xview"));
INSTANTIATE_TEST_SUITE_P(Sources, Layers, testing::Values("src"));

/// Third-party headers that only a few files may know, so that a change of the library is a change
/// of one place.
TEST(Fences, HeavyLibrariesStayOutOfPublicHeaders) {
  const std::regex heavy(
      R"(^\s*#\s*include\s*[<"](opencv2|ceres|embree3|sqlite3|SQLiteCpp|yaml-cpp|nlohmann|CLI|pcl/(registration|filters|segmentation|kdtree)))");
  for (const auto& entry :
       fs::recursive_directory_iterator(fs::path(XVIEW_SOURCE_DIR) / "include")) {
    if (!entry.is_regular_file()) continue;
    std::ifstream file(entry.path());
    std::string line;
    while (std::getline(file, line))
      EXPECT_FALSE(std::regex_search(line, heavy)) << entry.path() << ": " << line;
  }
}

TEST(Fences, CommandLineParserIsKnownToOneFile) {
  for (const char* folder : {"src", "pcd_tools"}) {
    for (const auto& entry :
         fs::recursive_directory_iterator(fs::path(XVIEW_SOURCE_DIR) / folder)) {
      if (entry.path().extension() != ".cpp" || entry.path().filename() == "tool.cpp") continue;
      std::ifstream file(entry.path());
      std::string line;
      while (std::getline(file, line))
        EXPECT_EQ(line.find("#include <CLI/"), std::string::npos) << entry.path();
    }
  }
}

}  // namespace
