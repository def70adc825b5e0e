// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <filesystem>

#include "support/program.h"
#include "support/test_data.h"

namespace xview::test {
namespace {

namespace fs = std::filesystem;

/// Whatever is in the file: an answer, or one line of refusal; never a crash, a hang, or a claim on
/// all memory.
bool expectPolite(const std::vector<std::string>& arguments) {
  const Outcome outcome = runXview(arguments, {10, 2500, ""});
  std::string what;
  for (const std::string& argument : arguments) what += argument + " ";
  EXPECT_EQ(outcome.signal, 0) << what;
  EXPECT_TRUE(outcome.code == 0 || outcome.code == 1)
      << what << "-> " << outcome.code << ": " << outcome.err;
  EXPECT_EQ(lineCount(outcome.err), outcome.code == 0 ? 0u : 1u) << what << outcome.err;
  EXPECT_EQ(outcome.err.find("out of memory"), std::string::npos) << what << outcome.err;
  return outcome.code == 0;
}

void expectPoliteWithAllOf(const std::string& folder) {
  const TemporaryFolder out;
  std::size_t files = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    if (expectPolite({"info", "-q", entry.path().string()}))
      expectPolite({"blobs", "-q", entry.path().string(), out / "blobs.pcd"});
    ++files;
  }
  EXPECT_GT(files, 10u);
}

TEST(RecordedFiles, DamagedCloudsAreRefusedOrRead) {
  XVIEW_REQUIRE_DATA(folder, "bad_files");
  expectPoliteWithAllOf(folder);
}

TEST(RecordedFiles, CloudsOfOtherProgramsAreRefusedOrRead) {
  XVIEW_REQUIRE_DATA(folder, "reader_variants");
  expectPoliteWithAllOf(folder);
}

}  // namespace
}  // namespace xview::test
