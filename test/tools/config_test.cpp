// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <sstream>

#include "support/program.h"
#include "support/test_data.h"

namespace xview::test {
namespace {

std::string effective(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "map");
  arguments.push_back("--print-config");
  const Outcome outcome = runXview(arguments);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  return outcome.out;
}

TEST(PrintConfig, IsReadBackToTheSameOptions) {
  const TemporaryFolder folder;
  const std::string printed =
      effective({"--walks.num_walks", "77", "--merge.mode", "first_observation", "--seed", "5"});
  EXPECT_NE(printed.find("77"), std::string::npos);
  writeText(folder / "a.yaml", printed);
  EXPECT_EQ(effective({"--config", folder / "a.yaml"}), printed);
}

TEST(PrintConfig, WorksWithoutACommand) {
  const Outcome outcome = runXview({"--print-config", "--seed", "9"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("seed: 9"), std::string::npos);
}

TEST(Config, HyphensAndUnderscoresBetweenWordsAreOne) {
  EXPECT_EQ(effective({"--walks.num-walks=77", "--graph-space", "image"}),
            effective({"--walks.num_walks", "77", "--graph_space=image"}));
  const Outcome outcome = runXview({"info", "--help_all"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(runXview({"info", "--", "--help_all"}).code, 1) << "is the name of a file";
}

TEST(Config, AnUnknownGraphSpaceNamesTheKnownOnes) {
  const Outcome outcome = runXview({"map", "--graph_space", "imag", "a", "b.xvm"});
  EXPECT_EQ(outcome.code, 2) << outcome.err;
  EXPECT_NE(outcome.err.find("image"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("cloud"), std::string::npos) << outcome.err;
}

TEST(Config, FlagsWinOverFilesWhereverTheyStand) {
  const TemporaryFolder folder;
  writeText(folder / "a.yaml", "seed: 11\n");
  EXPECT_NE(effective({"--seed", "12", "--config", folder / "a.yaml"}).find("seed: 12"),
            std::string::npos);
}

TEST(Config, LaterFilesWin) {
  const TemporaryFolder folder;
  writeText(folder / "a.yaml", "seed: 11\nwalks: {num_walks: 50}\n");
  writeText(folder / "b.yaml", "seed: 12\n");
  const std::string both =
      effective({"--config", folder / "a.yaml", "--config", folder / "b.yaml"});
  EXPECT_NE(both.find("seed: 12"), std::string::npos);
  EXPECT_NE(both.find("num_walks: 50"), std::string::npos);
}

TEST(Config, TakesOneFileAndLeavesTheOperandsBehindIt) {
  const TemporaryFolder folder;
  writeText(folder / "a.yaml", "seed: 11\n");
  const Outcome outcome =
      runXview({"localize", "--config", folder / "a.yaml", "/nowhere/q", "/nowhere/map"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.err.find("/nowhere/map"), std::string::npos) << outcome.err;
}

TEST(Config, UnknownKeyNamesFileAndNearestKey) {
  const TemporaryFolder folder;
  writeText(folder / "a.yaml", "walks:\n  num_wlks: 50\n");
  const Outcome outcome = runXview({"map", "--print-config", "--config", folder / "a.yaml"});
  EXPECT_NE(outcome.code, 0);
  EXPECT_EQ(outcome.out, "");
  EXPECT_NE(outcome.err.find("a.yaml:2"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("walks.num_walks"), std::string::npos) << outcome.err;
}

TEST(Config, AFileThatComesWithTheProgramHasAName) {
  EXPECT_EQ(effective({"--config", "paper/synthia"}),
            effective({"--config", XVIEW_SOURCE_DIR "/config/paper/synthia.yaml"}));
  const Outcome outcome = runXview({"map", "--print-config", "--config", "synthia_rear"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.err.find("paper/synthia"), std::string::npos) << outcome.err;
}

TEST(Config, ThePresetsOfThePaperSetEverythingThatThePaperSays) {
  const std::pair<const char*, double> presets[] = {
      {"paper/synthia", 10}, {"paper/airsim", 15}, {"paper/streetview", 15}};
  for (const auto& [name, merge_m] : presets) {
    const YAML::Node options = YAML::Load(effective({"--config", name}));
    const auto is = [&, preset = name](const char* group, const char* key,
                                       const std::string& value) {
      EXPECT_EQ(options[group][key].as<std::string>(), value)
          << preset << " " << group << "." << key;
    };
    EXPECT_EQ(options["method"].as<std::string>(), "walks");
    EXPECT_EQ(options["graph_space"].as<std::string>(), "regions");
    is("clean", "boundary_px", "4");
    is("merge", "mode", "first_observation");
    EXPECT_EQ(options["merge"]["first_observation_m"].as<double>(), merge_m) << name;
    is("walks", "num_walks", "200");
    is("walks", "immediate_return", "false");
    is("match", "rare_words", "false");
    is("posterior", "solver", "gauss_newton");
    is("refine", "enabled", "false");
  }
}

TEST(Config, MissingFileIsAFailureNotAMisuse) {
  EXPECT_EQ(runXview({"map", "--print-config", "--config", "/nowhere/a.yaml"}).code, 1);
}

/// Lines of a printed configuration, with the remark that a value is the default one.
std::vector<std::string> linesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::string withoutRemark(const std::string& line) { return line.substr(0, line.find("  # ")); }

TEST(Config, EveryShippedFileIsValidAndChangesSomething) {
  const std::vector<std::string> defaults = linesOf(effective({}));
  int files = 0;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(XVIEW_SOURCE_DIR "/config")) {
    const auto folder = entry.path().parent_path().filename();
    if (entry.path().extension() != ".yaml" || folder == "labels" || folder == "networks") continue;
    const std::vector<std::string> lines = linesOf(effective({"--config", entry.path().string()}));
    ASSERT_EQ(lines.size(), defaults.size());
    int changed = 0;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (lines[i] == defaults[i]) continue;
      EXPECT_NE(withoutRemark(lines[i]), withoutRemark(defaults[i]))
          << entry.path() << " sets what is the default anyway";
      ++changed;
    }
    EXPECT_GT(changed, 0) << entry.path();
    ++files;
  }
  EXPECT_GE(files, 3);
}

}  // namespace
}  // namespace xview::test
