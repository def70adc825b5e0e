// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <sstream>

#include "support/program.h"
#include "support/test_data.h"

namespace xview::test {
namespace {

const std::vector<std::string> kCommands{
    "simulate", "info", "label", "lift", "blobs",      "graph", "map",  "match",  "localize",
    "evaluate", "fuse", "learn", "view", "lookalikes", "diff",  "demo", "follow",
#ifdef XVIEW_WITH_SERVE
    "serve",
#endif
    "prune"};

TEST(Help, ListsEveryCommand) {
  const Outcome outcome = runXview({"--help"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.err, "");
  for (const std::string& command : kCommands)
    EXPECT_NE(outcome.out.find("\n  " + command + " "), std::string::npos);
}

TEST(Help, IsWhatXviewAloneAndXviewHelpSay) {
  const std::string help = runXview({"--help"}).out;
  for (const std::vector<std::string>& arguments :
       std::vector<std::vector<std::string>>{{}, {"help"}}) {
    const Outcome outcome = runXview(arguments);
    EXPECT_EQ(outcome.code, 0);
    EXPECT_EQ(outcome.out, help);
  }
  EXPECT_EQ(runXview({"help", "view"}).out, runXview({"view", "--help"}).out);
  const Outcome unknown = runXview({"help", "localise"});
  EXPECT_EQ(unknown.code, 2);
  EXPECT_NE(unknown.err.find("nearest known one is localize"), std::string::npos) << unknown.err;
}

TEST(Help, FitsOntoAScreen) {
  for (const std::string& command : kCommands) {
    const Outcome outcome = runXview({command, "--help"});
    EXPECT_LE(lineCount(outcome.out), 45u) << command;
    std::istringstream lines(outcome.out);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80u) << line;
  }
}

TEST(Help, OfEveryCommandIsOnStdoutWithAnExample) {
  for (const std::string& command : kCommands) {
    const Outcome outcome = runXview({command, "--help"});
    EXPECT_EQ(outcome.code, 0) << command;
    EXPECT_EQ(outcome.err, "") << command;
    EXPECT_NE(outcome.out.find("Usage: xview " + command), std::string::npos) << command;
    EXPECT_NE(outcome.out.find("Example: xview " + command), std::string::npos) << command;
    EXPECT_NE(outcome.out.find("Common flags:"), std::string::npos) << command;
  }
}

/// Once, for whoever looks for an option and not for a command.
TEST(Help, OfOptionsIsWhatAllCommandsHave) {
  const Outcome options = runXview({"help", "options"});
  EXPECT_EQ(options.code, 0) << options.err;
  const std::string all = runXview({"graph", "--help-all"}).out;
  const std::size_t stages = options.out.find("Options of prior:");
  ASSERT_NE(stages, std::string::npos);
  EXPECT_NE(all.find(options.out.substr(stages)), std::string::npos);
  EXPECT_EQ(options.out.find("--frames"), std::string::npos) << "of a command";
}

TEST(Help, ShowsOptionsByStageWithDefaultAndUnit) {
  const std::string all = runXview({"graph", "--help-all"}).out;
  EXPECT_NE(all.find("Options of walks:"), std::string::npos);
  const std::size_t radius = all.find("--edges.radius_m");
  ASSERT_NE(radius, std::string::npos);
  EXPECT_NE(all.find("(default 15)", radius), std::string::npos);
  EXPECT_EQ(runXview({"graph", "--help"}).out.find("--walks.num_walks"), std::string::npos);
}

TEST(Help, WritesPagesForManAndWordsForBash) {
  const TemporaryFolder folder;
  ASSERT_EQ(runXview({"help", "--write", folder.path()}).code, 0);
  const std::string completion = readText(folder.path() + "/completions/xview");
  for (const std::string& command : kCommands) {
    const std::string page = readText(folder.path() + "/man1/xview-" + command + ".1");
    EXPECT_EQ(page.rfind(".TH XVIEW", 0), 0u) << command;
    EXPECT_NE(page.find("\\-\\-walks.num_walks"), std::string::npos) << command;
    EXPECT_NE(completion.find("\n    " + command + ") flags="), std::string::npos) << command;
  }
  EXPECT_NE(completion.find("--method) mapfile -t COMPREPLY < <(compgen -W \"auto walks search\""),
            std::string::npos);
}

TEST(Version, IsOneLineOnStdout) {
  const Outcome outcome = runXview({"--version"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.out.rfind("xview ", 0), 0u);
  EXPECT_EQ(lineCount(outcome.out), 1u);
}

void expectMisuse(const std::vector<std::string>& arguments, const std::string& expected) {
  const Outcome outcome = runXview(arguments);
  EXPECT_EQ(outcome.code, 2) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(lineCount(outcome.err), 2u) << outcome.err;
  EXPECT_EQ(outcome.err.rfind("error: ", 0), 0u) << outcome.err;
  EXPECT_NE(outcome.err.find(expected), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("see: xview"), std::string::npos) << outcome.err;
}

TEST(Misuse, NoCommand) { expectMisuse({"--quiet"}, "no command"); }
TEST(Misuse, AFarFetchedCommandIsNotSuggested) {
  const Outcome outcome = runXview({"town.xvm"});
  EXPECT_EQ(outcome.err.find("nearest"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("known are demo, simulate, info"), std::string::npos) << outcome.err;
}
TEST(Misuse, ThereIsOneOutput) {
  expectMisuse({"lift", "a", "b.pcd", "-o", "c.pcd"}, "INPUT CLOUD.pcd");
}
TEST(Misuse, UnknownCommandNamesTheNearest) { expectMisuse({"localise", "a", "b"}, "localize"); }
TEST(Misuse, UnknownFlagNamesTheNearest) {
  expectMisuse({"localize", "a", "b", "--windw", "3"}, "--window");
}
TEST(Misuse, UnknownKeyNamesTheNearest) {
  expectMisuse({"graph", "a", "b.ply", "--walks.num_walk", "3"}, "--walks.num_walks");
}
TEST(Misuse, TooFewOperands) { expectMisuse({"localize", "a"}, "QUERY... MAP"); }
TEST(Misuse, TooManyOperands) { expectMisuse({"lift", "a", "b.pcd", "c"}, "INPUT CLOUD.pcd"); }
TEST(Misuse, ValueOutOfRange) {
  expectMisuse({"graph", "a", "b.ply", "--walks.walk_length", "0"}, "walks.walk_length");
}
TEST(Misuse, ValueIsNoNumber) {
  expectMisuse({"graph", "a", "b.ply", "--edges.radius_m", "far"}, "edges.radius_m");
}
TEST(Misuse, ValueIsNoChoice) {
  expectMisuse({"graph", "a", "b.ply", "--method", "magic"}, "method");
}
TEST(Misuse, FlagWithoutValue) { expectMisuse({"localize", "a", "b", "--window"}, "--window"); }
TEST(Misuse, BadFrameRange) { expectMisuse({"info", "a", "--frames", "9:x"}, "9:x"); }
TEST(Misuse, OutputOfUnknownKind) { expectMisuse({"lift", "a", "b.txt"}, ".pcd"); }
TEST(Misuse, StrideWithoutWindow) {
  expectMisuse({"localize", "a", "b", "--stride", "3"}, "--window");
}

TEST(Misuse, SequenceAndTrackNeedWindows) {
  expectMisuse({"localize", "a", "b", "--sequence"}, "--window");
  expectMisuse({"localize", "a", "b", "--track"}, "--window");
  expectMisuse({"localize", "a", "b", "--window", "9", "--track", "--sequence"}, "exclude");
}

TEST(Misuse, AMapEndsWithXvm) {
  for (const char* out : {"b.pcd", "b.ply", "b", "town/forward"})
    expectMisuse({"map", "a", out}, std::string(out) + ": a map ends with .xvm");
}

TEST(Misuse, APriorIsRefusedUnderTheNameThatWasTyped) {
  expectMisuse({"localize", "a", "b", "--risk", "0.7"},
               "error: --risk = 0.7, must be in [1e-9, 0.5]");
  expectMisuse({"localize", "a", "b", "--near", "1,2"}, "error: --near = 1,2, must be x,y,radius");
  expectMisuse({"localize", "a", "b", "--near", "1,2,-3"}, "error: --near = 1,2,-3, the radius");
  expectMisuse({"localize", "a", "b", "--yaw", "north,5"}, "error: --yaw = north,5, 'north'");
}

TEST(Misuse, CommonFlagsMayStandBeforeTheCommand) {
  const Outcome outcome = runXview({"--threads", "2", "--quiet", "localize", "a"});
  EXPECT_NE(outcome.err.find("QUERY... MAP"), std::string::npos) << outcome.err;
}

TEST(Misuse, PointsToTheHelpOfTheCommand) {
  EXPECT_NE(runXview({"localize", "a"}).err.find("see: xview localize --help"), std::string::npos);
}

}  // namespace
}  // namespace xview::test
