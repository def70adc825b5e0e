// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace xview::test {

/// A header or source of the project.
struct SourceFile {
  std::filesystem::path path;
  std::string place;  ///< see placeOf
  std::string text;
};

/// The room that a file belongs to: its folder under include/xview or src, of what lies directly in
/// include/xview that of its source; "tools" for pcd_tools.
std::string placeOf(const std::filesystem::path& path);

/// All .h and .cpp below include, src, pcd_tools and python.
std::vector<SourceFile> sourceFiles();

/// The file that `#include "name"` or `#include <name>` means in this file; empty if it is none of
/// ours.
std::filesystem::path includedFile(const SourceFile& from, const std::string& name);

/// C++ without comments, preprocessor lines and the insides of literals; lines stay lines.
std::string bareCode(const std::string& text);

}  // namespace xview::test
