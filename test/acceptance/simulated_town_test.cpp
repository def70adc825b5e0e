// SPDX-License-Identifier: BSD-3-Clause
// A town of our own: scans found in the map of a camera, and the commands of the README.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "acceptance/answers.h"
#include "support/program.h"
#include "support/test_data.h"

namespace xview::test {
namespace {

namespace fs = std::filesystem;

/// Simulates the town of the tests once; `town/` in a folder where commands may leave their files.
class SimulatedTown : public testing::Test {
 protected:
  void SetUp() override {
#ifndef XVIEW_WITH_SIM
    GTEST_SKIP() << "this build has no simulator (Embree is missing)";
#endif
    if (folder_) return;
    folder_ = new TemporaryFolder;
    outputOf({"simulate", "--quiet", *folder_ / "town", "--seed", "5", "--route_length_m", "130",
              "--width", "160", "--height", "120", "--sessions.oblique", "--sessions.lidar"});
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  static std::string file(const std::string& name) { return *folder_ / name; }

  static TemporaryFolder* folder_;
};
TemporaryFolder* SimulatedTown::folder_ = nullptr;

TEST_F(SimulatedTown, ScansAreFoundInTheMapOfACamera) {
  outputOf({"map", "--quiet", file("town/forward"), file("camera.xvm")});
  const Tally tally = tallyOf(localize({file("town/lidar_reverse"), "--window", "10", "--stride",
                                        "20", file("camera.xvm")}),
                              positionsIn(file("town/lidar_reverse/groundtruth.txt")), 0.5);
  EXPECT_GE(tally.windows, 3u);
  EXPECT_EQ(tally.wrong, 0u) << tally.reasons;
  EXPECT_GE(tally.accepted, 2u) << tally.reasons;
}

/// Lines of the code blocks of a page that call the program, in order.
std::vector<std::string> commandsOf(const std::string& page) {
  std::vector<std::string> commands;
  std::istringstream lines(readText(XVIEW_SOURCE_DIR "/" + page));
  bool fenced = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("```", 0) == 0) fenced = !fenced;
    const bool indented = line.rfind("    ", 0) == 0;
    if (!fenced && !indented) continue;
    const std::string command = line.substr(std::min(line.size(), line.find_first_not_of(' ')));
    if (command.rfind("build/xview ", 0) == 0 || command.rfind("xview ", 0) == 0)
      commands.push_back(command);
  }
  return commands;
}

/// Runs a line as a user would, in a folder where build/xview is the program. The line may end with
/// a comment and has redirections of its own.
int runLine(const std::string& folder, const std::string& command) {
  const std::string script = "cd '" + folder + "' && PATH=build:$PATH && {\n" + command +
                             "\n} > last_output 2> last_errors";
  const int status = std::system(script.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// README and tutorial speak of the town of `./run demo` and of clouds of it. What else their
/// commands need they make themselves, so they run in order; lines of other programs (pdal,
/// pcl_viewer) are none of ours.
TEST_F(SimulatedTown, CommandsOfReadmeAndTutorialRunInTheirOrder) {
  fs::create_directory(file("build"));
  fs::create_symlink(XVIEW_PROGRAM, file("build/xview"));
  fs::create_directory(file("demo"));
  fs::create_directory_symlink(file("town"), file("demo/town"));
  for (const auto& [page, least] :
       {std::pair("README.md", 5u), std::pair("docs/tutorial.md", 12u)}) {
    const std::vector<std::string> commands = commandsOf(page);
    EXPECT_GE(commands.size(), least) << page;
    for (const std::string& command : commands) {
      const int code = runLine(folder_->path(), command);
      EXPECT_EQ(code, 0) << page << ": " << command << " ended with " << code << "\n"
                         << readText(file("last_errors"));
    }
  }
}

}  // namespace
}  // namespace xview::test
