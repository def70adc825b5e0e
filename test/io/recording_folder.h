// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "small_files.h"
#include "support/test_data.h"
#include "xview/io/recording.h"

namespace xview::test {

/// A folder in which each test builds its recording.
class RecordingFolder : public ::testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& bytes) const {
    writeText(folder_ / name, bytes);
    return folder_ / name;
  }
  std::string openMessage(const std::string& path, const io::InputOptions& options = {}) const {
    return messageOf([&] { io::openRecording(path, options); });
  }

  TemporaryFolder folder_;
};

}  // namespace xview::test
