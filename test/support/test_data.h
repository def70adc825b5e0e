// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <exception>
#include <string>

namespace xview::test {

/// Folder with the recorded data: $XVIEW_DATA, or shared/data beside the source tree; empty if
/// there is none.
std::string dataFolder();

/// A fresh folder that is removed when the object goes.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::string& path() const { return path_; }
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

/// The bytes of a file; empty if it cannot be read.
std::string readText(const std::string& path);
/// Writes a file anew, and makes the folders that it lies in.
void writeText(const std::string& path, const std::string& text);

/// What the exception says that a call throws; empty if it throws none. Others are not caught.
template <class Exception = std::exception, class Call>
std::string messageOf(Call&& call) {
  try {
    call();
  } catch (const Exception& problem) {
    return problem.what();
  }
  return "";
}

}  // namespace xview::test

/// Skips the test with a message when the recorded data is absent; defines `data` as its folder
/// otherwise.
#define XVIEW_REQUIRE_DATA(data, subfolder)                                       \
  const std::string data = ::xview::test::dataFolder().empty()                    \
                               ? std::string()                                    \
                               : ::xview::test::dataFolder() + "/" + (subfolder); \
  if (data.empty()) GTEST_SKIP() << "recorded data not found; set XVIEW_DATA to its folder"
