// SPDX-License-Identifier: BSD-3-Clause
#include "architecture/source_files.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <map>
#include <sstream>

namespace xview::test {
namespace {

namespace fs = std::filesystem;

const fs::path kRoot = XVIEW_SOURCE_DIR;

std::string contentOf(const fs::path& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// Where the literal that begins with this quotation mark ends, behind its last mark.
std::size_t endOfLiteral(const std::string& text, std::size_t first) {
  const char quote = text[first];
  if (quote == '"' && first > 0 && text[first - 1] == 'R') {
    const std::size_t open = text.find('(', first);
    const std::string close = ")" + text.substr(first + 1, open - first - 1) + "\"";
    return std::min(text.size(), text.find(close, open) + close.size());
  }
  std::size_t i = first + 1;
  while (i < text.size() && text[i] != quote && text[i] != '\n') i += text[i] == '\\' ? 2 : 1;
  return std::min(text.size(), i + 1);
}

std::size_t endOfLine(const std::string& text, std::size_t first) {
  std::size_t end = text.find('\n', first);
  while (end != std::string::npos && end > 0 && text[end - 1] == '\\')
    end = text.find('\n', end + 1);
  return std::min(text.size(), end);
}

bool isLiteral(const std::string& text, std::size_t i) {
  if (text[i] == '"') return true;
  // 1'000 has no literal in it.
  return text[i] == '\'' && (i == 0 || !std::isalnum(static_cast<unsigned char>(text[i - 1])));
}

bool isDirective(const std::string& text, std::size_t i) {
  if (text[i] != '#') return false;
  const std::size_t before = text.find_last_not_of(" \t", i == 0 ? 0 : i - 1);
  return i == 0 || before == std::string::npos || text[before] == '\n';
}

}  // namespace

std::string placeOf(const fs::path& path) {
  static const std::map<std::string, std::string> kRoomsOfPipelines = {
      {"xview", "tools"},  // the header for programs, which puts all together
      {"options", "base"},        {"cloud_recording", "place"}, {"place_builder", "place"},
      {"localizer", "localizer"}, {"sequence", "localizer"},    {"follower", "localizer"},
      {"mapper", "compare"}};
  fs::path inside = path.lexically_relative(kRoot);
  auto part = inside.begin();
  if (*part == "pcd_tools") return "tools";
  if (*part == "python") return "python";
  std::advance(part, *part == "include" ? 2 : 1);  // include/xview, src
  if (std::next(part) != inside.end()) return part->string();
  const auto room = kRoomsOfPipelines.find(part->stem().string());
  return room == kRoomsOfPipelines.end() ? "" : room->second;
}

std::vector<SourceFile> sourceFiles() {
  std::vector<SourceFile> files;
  for (const char* folder : {"include", "src", "pcd_tools", "python"}) {
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
      const std::string ending = entry.path().extension().string();
      if (ending == ".h" || ending == ".cpp")
        files.push_back({entry.path(), placeOf(entry.path()), contentOf(entry.path())});
    }
  }
  std::sort(files.begin(), files.end(),
            [](const SourceFile& a, const SourceFile& b) { return a.path < b.path; });
  return files;
}

fs::path includedFile(const SourceFile& from, const std::string& name) {
  for (const fs::path& folder : {from.path.parent_path(), kRoot / "include", kRoot / "src"}) {
    const fs::path path = (folder / name).lexically_normal();
    if (fs::is_regular_file(path)) return path;
  }
  return {};
}

std::string bareCode(const std::string& text) {
  std::string code;
  for (std::size_t i = 0; i < text.size();) {
    if (text.compare(i, 2, "//") == 0 || isDirective(text, i)) {
      i = endOfLine(text, i);
    } else if (text.compare(i, 2, "/*") == 0) {
      i = std::min(text.size(), text.find("*/", i) + 2);
    } else if (isLiteral(text, i)) {
      code += "\"\"";
      i = endOfLiteral(text, i);
    } else {
      code += text[i++];
    }
  }
  return code;
}

}  // namespace xview::test
