// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "architecture/source_files.h"

namespace xview::test {
namespace {

/// From below to above. A place may include what lies in the lines below it, and itself; places of
/// one line do not know one another. See docs/architecture.md.
const std::vector<std::vector<std::string>> kLayers = {
    {"types"},
    {"io", "label", "graph", "search", "match", "verify", "pose", "sim", "eval"},
    {"map", "options"},
    {"pipeline"},
    {"view"},
    {"tools"},
};

/// Only the tools put these together with the rest: the core knows no files, worlds or reports.
const std::set<std::string> kRim = {"io", "sim", "eval"};

std::size_t layerOf(const std::string& place) {
  for (std::size_t i = 0; i < kLayers.size(); ++i) {
    if (std::count(kLayers[i].begin(), kLayers[i].end(), place)) return i;
  }
  ADD_FAILURE() << place << " is a folder that has no place in the table of layers";
  return 0;
}

bool mayInclude(const std::string& place, const std::string& target) {
  if (place == target) return true;
  if (kRim.count(target) && place != "tools") return false;
  return layerOf(target) < layerOf(place);
}

std::vector<std::string> includesOf(const SourceFile& file) {
  static const std::regex include(R"(^\s*#\s*include\s*[<"]([^">]+)[">])");
  std::vector<std::string> names;
  std::istringstream lines(file.text);
  std::smatch match;
  for (std::string line; std::getline(lines, line);) {
    if (std::regex_search(line, match, include)) names.push_back(match[1]);
  }
  return names;
}

/// Public headers and private ones, of src and of pcd_tools.
TEST(Layers, IncludeOnlyWhatIsBelowThem) {
  std::size_t ours = 0;
  for (const SourceFile& file : sourceFiles()) {
    for (const std::string& name : includesOf(file)) {
      const std::filesystem::path target = includedFile(file, name);
      if (target.empty()) continue;
      ++ours;
      EXPECT_TRUE(mayInclude(file.place, placeOf(target)))
          << file.path.string() << ": " << file.place << " may not include " << name;
    }
  }
  EXPECT_GT(ours, 500u) << "the scan has missed most of the project";
}

/// A private header of another folder is none of ours to include, even of a layer below.
TEST(Layers, PrivateHeadersStayInTheirFolder) {
  for (const SourceFile& file : sourceFiles()) {
    for (const std::string& name : includesOf(file)) {
      const std::filesystem::path target = includedFile(file, name);
      const bool is_private = target.string().rfind(XVIEW_SOURCE_DIR "/src/", 0) == 0;
      if (!is_private) continue;
      EXPECT_EQ(file.place, placeOf(target)) << file.path.string() << " includes " << name;
    }
  }
}

/// Nouns and pipelines are `xview` itself, and so are the worlds, reports and drawings at the rim.
const std::set<std::string> kPlain = {"types", "options", "pipeline", "sim", "eval", "view"};

/// What lies in another folder is `xview::FOLDER`, so that no two folders can define one name
/// differently. A folder that leaves the list above does so with all its files.
TEST(Namespaces, AreThoseOfTheFolder) {
  std::map<std::string, std::vector<std::string>> without;
  std::set<std::string> own = {"tools"};
  for (const SourceFile& file : sourceFiles()) {
    const std::string code = bareCode(file.text);
    if (code.find("namespace") == std::string::npos) continue;
    const std::regex of_the_folder("namespace xview::" + file.place + R"(\b)");
    if (std::regex_search(code, of_the_folder) || !kPlain.count(file.place)) own.insert(file.place);
    if (!std::regex_search(code, of_the_folder)) without[file.place].push_back(file.path.string());
  }
  for (const std::string& place : own) {
    EXPECT_TRUE(without[place].empty())
        << "not in xview::" << place << ": " << testing::PrintToString(without[place]);
  }
}

/// Third-party headers that only a few files may know, so that a change of the library is a change
/// of one place.
TEST(Fences, HeavyLibrariesStayOutOfPublicHeaders) {
  const std::regex heavy(
      "(opencv2|ceres|embree3|sqlite3|SQLiteCpp|yaml-cpp|nlohmann|CLI|pcl/"
      "(registration|filters|segmentation|kdtree)).*");
  for (const SourceFile& file : sourceFiles()) {
    if (file.path.string().rfind(XVIEW_SOURCE_DIR "/include/", 0) != 0) continue;
    for (const std::string& name : includesOf(file))
      EXPECT_FALSE(std::regex_match(name, heavy)) << file.path.string() << ": " << name;
  }
}

/// Commands declare flags through an interface of their own; the manual lists what the parser
/// knows.
TEST(Fences, CommandLineParserIsKnownToTwoFiles) {
  std::set<std::string> knowing;
  for (const SourceFile& file : sourceFiles()) {
    for (const std::string& name : includesOf(file)) {
      if (name.rfind("CLI/", 0) == 0) knowing.insert(file.path.filename().string());
    }
  }
  EXPECT_EQ(knowing, (std::set<std::string>{"manual.cpp", "program.cpp"}));
}

}  // namespace
}  // namespace xview::test
