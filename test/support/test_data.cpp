// SPDX-License-Identifier: BSD-3-Clause
#include "support/test_data.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace xview::test {

std::string dataFolder() {
  const char* set = std::getenv("XVIEW_DATA");
  const std::filesystem::path folder = set ? set : XVIEW_SOURCE_DIR "/../shared/data";
  return std::filesystem::is_directory(folder) ? folder.string() : std::string();
}

std::string readText(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

void writeText(const std::string& path, const std::string& text) {
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  std::filesystem::remove(path);  // some file systems are slow to overwrite
  std::ofstream(path, std::ios::binary) << text;
}

TemporaryFolder::TemporaryFolder() {
  std::string pattern = (std::filesystem::temp_directory_path() / "xview_test_XXXXXX").string();
  if (!mkdtemp(pattern.data())) std::abort();
  path_ = pattern;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace xview::test
