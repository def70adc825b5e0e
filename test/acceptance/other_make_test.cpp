// SPDX-License-Identifier: BSD-3-Clause
// Worlds by a renderer that shares no code with the program (bench/other_worlds): classes with
// names of its own and no roles, labels wrong in patches, odometry that drifts. Needs no data set.
#include <gtest/gtest.h>

#include "acceptance/answers.h"
#include "support/program.h"

namespace xview::test {
namespace {

/// Renders sessions of the world of this style and seed and returns its folder.
std::string render(const std::string& style, const std::string& seed, const TemporaryFolder& folder,
                   const std::vector<std::string>& sessions) {
  const std::string world = folder / (style + "_" + seed);
  std::vector<std::string> arguments{style, seed, world};
  arguments.insert(arguments.end(), sessions.begin(), sessions.end());
  const Outcome rendered = runProgram(XVIEW_OTHER_WORLDS, arguments, {300, 0, "", 0});
  EXPECT_EQ(rendered.code, 0) << rendered.err;
  return world;
}

TEST(HomeOfAnotherMake, IsFoundLookingBackAndAnotherHomeIsRefused) {
  const TemporaryFolder folder;
  const std::string home = render("home", "7", folder, {"forward", "rear"}),
                    elsewhere = render("home", "8", folder, {"rear"});
  const std::string map = folder / "home.xvm";
  outputOf({"map", "--quiet", home + "/forward", map});
  const std::vector<std::string> windows{"--window", "40", "--stride", "40", map};
  const auto answersOf = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), windows.begin(), windows.end());
    return localize(arguments);
  };
  const Tally found =
      tallyOf(answersOf({home + "/rear"}), positionsIn(home + "/rear/groundtruth.txt"), 0.1);
  EXPECT_EQ(found.windows, 5U);
  EXPECT_EQ(found.right, 5U) << found.reasons;
  EXPECT_EQ(found.wrong, 0U) << found.reasons;
  EXPECT_GE(found.accepted, 1U) << found.reasons;
  const Tally refused = tallyOfNegatives(answersOf({elsewhere + "/rear"}));
  EXPECT_GE(refused.windows, 4U);
  EXPECT_EQ(refused.accepted, 0U) << refused.reasons;
}

/// Check fix for: rays passed through ground that was labelled as a thing, and 4 of 11 scans at the
/// right place were accepted.
TEST(CarParkOfAnotherMake, SingleScansWithWrongLabelsAreFound) {
  const TemporaryFolder folder;
  const std::string place = render("carpark", "7", folder, {"lidar", "lidar_reverse"});
  const std::string map = folder / "carpark.xvm", scans = place + "/lidar_reverse";
  outputOf({"map", "--quiet", place + "/lidar", map});
  const Tally found = tallyOf(localize({scans, map, "--window", "1", "--stride", "25"}),
                              positionsIn(scans + "/groundtruth.txt"), 0.1);
  EXPECT_EQ(found.windows, 11U);
  EXPECT_EQ(found.wrong, 0U) << found.reasons;
  EXPECT_GE(found.accepted, 9U) << found.reasons;
}

}  // namespace
}  // namespace xview::test
