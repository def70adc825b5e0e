// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

namespace {

/// Writes how every test ended, so that `./run test` can count over all binaries (summary.awk): a
/// line `started NAME` and a line `passed|failed|skipped NAME REASON` per test, with tabs between.
/// A test that only started is one that took its binary with it.
class TestLog final : public testing::EmptyTestEventListener {
 public:
  explicit TestLog(const std::string& path) : file_(path) {}

  void OnTestStart(const testing::TestInfo& test) override { write("started", test, ""); }

  void OnTestEnd(const testing::TestInfo& test) override {
    const testing::TestResult& result = *test.result();
    if (result.Failed()) return write("failed", test, "");
    if (!result.Skipped()) return write("passed", test, "");
    std::string reason;
    for (int i = 0; i < result.total_part_count(); ++i) {
      if (result.GetTestPartResult(i).skipped()) reason = result.GetTestPartResult(i).message();
    }
    std::replace(reason.begin(), reason.end(), '\n', ' ');
    write("skipped", test, reason);
  }

 private:
  void write(const char* what, const testing::TestInfo& test, const std::string& reason) {
    file_ << what << '\t' << test.test_suite_name() << '.' << test.name() << '\t' << reason
          << std::endl;
  }

  std::ofstream file_;
};

}  // namespace

int main(int argc, char** argv) {
  // Shells have what they start in the background ignore these, and so would the programs under
  // test.
  for (const int number : {SIGINT, SIGHUP}) std::signal(number, SIG_DFL);
  testing::InitGoogleTest(&argc, argv);
  if (const char* folder = std::getenv("XVIEW_TEST_LOG")) {
    const std::string name = std::filesystem::path(argv[0]).filename().string();
    // The list of listeners owns it.
    testing::UnitTest::GetInstance()->listeners().Append(
        new TestLog(std::string(folder) + "/" + name + ".tsv"));
  }
  return RUN_ALL_TESTS();
}
