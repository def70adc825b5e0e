// SPDX-License-Identifier: BSD-3-Clause
#pragma once

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

}  // namespace xview::test

/// Skips the test with a message when the recorded data is absent; defines `data` as its folder
/// otherwise.
#define XVIEW_REQUIRE_DATA(data, subfolder)                                       \
  const std::string data = ::xview::test::dataFolder().empty()                    \
                               ? std::string()                                    \
                               : ::xview::test::dataFolder() + "/" + (subfolder); \
  if (data.empty()) GTEST_SKIP() << "recorded data not found; set XVIEW_DATA to its folder"
