// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>

#include "xview/base/error.h"

/// What libFuzzer calls with every input; 0 keeps it if it reached new code.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace xview::fuzz {

/// A folder in memory, for readers that take paths. One for each process; never removed by it,
/// because a finding ends the process anyhow: its name has its number.
inline const std::string& scratch() {
  static const std::string folder = [] {
    const char* const root = std::getenv("XVIEW_FUZZ_SCRATCH");
    std::string path =
        (root ? root : "/dev/shm") + std::string("/xview_fuzz_") + std::to_string(getpid());
    std::filesystem::create_directories(path);
    return path;
  }();
  return folder;
}

inline std::string written(const std::string& name, const std::string& bytes) {
  const std::string path = scratch() + "/" + name;
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

/// True if the work was done, false if it was refused as the library refuses bad files; any other
/// exception ends the process, as a crash does.
template <class Work>
bool isDone(Work&& work) {
  try {
    work();
    return true;
  } catch (const Error&) {
  } catch (const UsageError&) {
  }
  return false;
}

/// Ends the process unless it holds.
inline void require(bool holds) {
  if (!holds) std::abort();
}

/// Texts that are put together into one input, each behind a line "@@ NAME".
template <class Take>
void forEachFile(const std::string& all, Take&& take) {
  constexpr std::size_t kMostFiles = 40;
  std::size_t begin = all.rfind("@@ ", 0) == 0 ? 3 : std::string::npos;
  for (std::size_t i = 0; begin != std::string::npos && i < kMostFiles; ++i) {
    const std::size_t line_end = std::min(all.find('\n', begin), all.size());
    const std::string name = all.substr(begin, line_end - begin);
    const std::size_t next = all.find("\n@@ ", line_end);
    const std::size_t text = std::min(line_end + 1, all.size());
    take(name, all.substr(text, next == std::string::npos ? next : next - text));
    begin = next == std::string::npos ? next : next + 4;
  }
}

/// A fresh folder with these files; names that would lead out of it, or are odd, are left out.
inline std::string writtenFolder(const std::string& name, const std::string& all) {
  namespace fs = std::filesystem;
  const std::string folder = scratch() + "/" + name;
  const auto is_harmless = [](const std::string& file) {
    return !file.empty() && file.size() < 80 && file.front() != '/' &&
           file.find("..") == std::string::npos &&
           std::all_of(file.begin(), file.end(), [](unsigned char c) {
             return std::isalnum(c) || c == '_' || c == '.' || c == '/' || c == '-';
           });
  };
  fs::remove_all(folder);
  fs::create_directories(folder);
  forEachFile(all, [&](const std::string& file, const std::string& bytes) {
    std::error_code failed;
    if (!is_harmless(file)) return;
    fs::create_directories(fs::path(folder + "/" + file).parent_path(), failed);
    if (!failed) written(name + "/" + file, bytes);
  });
  return folder;
}

}  // namespace xview::fuzz
