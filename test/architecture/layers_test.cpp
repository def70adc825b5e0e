// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "architecture/source_files.h"

namespace xview::test {
namespace {

/// From below to above. A room may include what lies in the lines above it in this table, and
/// itself; rooms of one line do not know one another. See docs/architecture.md.
const std::vector<std::vector<std::string>> kLayers = {
    {"base"},      {"process"}, {"place", "search", "pose"}, {"match"}, {"verdict"}, {"map"},
    {"localizer"}, {"compare"}, {"io", "sim", "eval"},       {"view"},  {"tools"},   {"python"},
};

constexpr std::size_t kMostPublicHeaders = 22;

/// Only the tools put these together with the rest: the library knows no files, worlds or reports.
const std::set<std::string> kRim = {"io", "sim", "eval", "view"};

std::size_t layerOf(const std::string& room) {
  for (std::size_t i = 0; i < kLayers.size(); ++i) {
    if (std::count(kLayers[i].begin(), kLayers[i].end(), room)) return i;
  }
  ADD_FAILURE() << room << " is a folder that has no place in the table of layers";
  return 0;
}

bool mayInclude(const std::string& room, const std::string& target) {
  if (room == target) return true;
  if (kRim.count(target) && room != "tools" && room != "python") return false;
  return layerOf(target) < layerOf(room);
}

bool isPrivate(const std::filesystem::path& header) {
  return header.string().rfind(XVIEW_SOURCE_DIR "/src/", 0) == 0;
}

/// The headers of src/ROOM that its doors.txt opens to other rooms.
std::set<std::string> doorsOf(const std::string& room) {
  std::set<std::string> doors;
  std::ifstream file(std::filesystem::path(XVIEW_SOURCE_DIR) / "src" / room / "doors.txt");
  for (std::string line; std::getline(file, line);) {
    if (!line.empty() && line[0] != '#') doors.insert(line);
  }
  return doors;
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

/// A header of src is known to its room alone, unless doors.txt of that room names it; what is
/// named there is used by another room.
TEST(Doors, AreThoseOfDoorsTxt) {
  std::map<std::string, std::set<std::string>> used;
  for (const SourceFile& file : sourceFiles()) {
    for (const std::string& name : includesOf(file)) {
      const std::filesystem::path target = includedFile(file, name);
      if (target.empty() || !isPrivate(target)) continue;
      const std::string room = placeOf(target);
      if (file.place == room) continue;
      const std::string header =
          target.lexically_relative(XVIEW_SOURCE_DIR "/src/" + room).string();
      EXPECT_TRUE(doorsOf(room).count(header))
          << file.path.string() << " includes " << name << ", which is no door of " << room;
      used[room].insert(header);
    }
  }
  for (const auto& layer : kLayers) {
    for (const std::string& room : layer) {
      for (const std::string& header : doorsOf(room))
        EXPECT_TRUE(used[room].count(header))
            << "no other room enters by " << room << "/" << header;
    }
  }
}

/// What is installed needs nothing that is not.
TEST(Doors, PublicHeadersIncludeNoPrivateOnes) {
  std::size_t headers = 0;
  for (const SourceFile& file : sourceFiles()) {
    if (file.path.string().rfind(XVIEW_SOURCE_DIR "/include/", 0) != 0) continue;
    ++headers;
    for (const std::string& name : includesOf(file)) {
      const std::filesystem::path target = includedFile(file, name);
      EXPECT_FALSE(!target.empty() && isPrivate(target)) << file.path.string() << ": " << name;
    }
  }
  EXPECT_LE(headers, kMostPublicHeaders);
}

/// Nouns, places and pipelines are `xview` itself, and so are the worlds, reports and drawings at
/// the rim.
const std::set<std::string> kPlain = {"base",    "process", "place", "localizer",
                                      "compare", "sim",     "eval",  "view"};

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
