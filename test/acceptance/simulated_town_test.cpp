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

/// Lines of the README's code blocks that call the program, in order.
std::vector<std::string> commandsOfTheReadme() {
  std::vector<std::string> commands;
  std::istringstream lines(readText(XVIEW_SOURCE_DIR "/README.md"));
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

/// The README speaks of a town, of a scan in it and of a cloud of the town. What else its commands
/// need they make themselves, so they run in order; lines of other programs (pdal, CloudCompare)
/// are none of ours.
TEST_F(SimulatedTown, CommandsOfTheReadmeRunInTheirOrder) {
  outputOf({"lift", "--quiet", file("town/rear"), "--frames", "20:50", file("scan.pcd")});
  outputOf({"lift", "--quiet", file("town/forward"), file("town.pcd")});
  fs::create_directory(file("build"));
  fs::create_symlink(XVIEW_PROGRAM, file("build/xview"));
  const std::vector<std::string> commands = commandsOfTheReadme();
  EXPECT_GE(commands.size(), 8u);
  for (const std::string& command : commands) {
    const int code = runLine(folder_->path(), command);
    const bool some_refused = code == 3 && command.find("--window") != std::string::npos;
    EXPECT_TRUE(code == 0 || some_refused) << command << " ended with " << code << "\n"
                                           << readText(file("last_errors"));
  }
}

}  // namespace
}  // namespace xview::test
