// SPDX-License-Identifier: BSD-3-Clause
// A home by a renderer that shares no code with the program (bench/other_worlds): classes with
// names of its own and no roles, labels wrong in patches, odometry that drifts. Needs no data set.
#include <gtest/gtest.h>

#include "acceptance/answers.h"
#include "support/program.h"

namespace xview::test {
namespace {

/// Renders sessions of the home of this seed and returns its folder.
std::string renderHome(const std::string& seed, const TemporaryFolder& folder,
                       const std::vector<std::string>& sessions) {
  const std::string home = folder / ("home_" + seed);
  std::vector<std::string> arguments{"home", seed, home};
  arguments.insert(arguments.end(), sessions.begin(), sessions.end());
  const Outcome rendered = runProgram(XVIEW_OTHER_WORLDS, arguments, {300, 0, "", 0});
  EXPECT_EQ(rendered.code, 0) << rendered.err;
  return home;
}

TEST(HomeOfAnotherMake, IsFoundLookingBackAndAnotherHomeIsRefused) {
  const TemporaryFolder folder;
  const std::string home = renderHome("7", folder, {"forward", "rear"}),
                    elsewhere = renderHome("8", folder, {"rear"});
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
  EXPECT_EQ(found.wrong, 0U) << found.reasons;
  EXPECT_GE(found.accepted, 3U) << found.reasons;
  const Tally refused = tallyOfNegatives(answersOf({elsewhere + "/rear"}));
  EXPECT_GE(refused.windows, 4U);
  EXPECT_EQ(refused.accepted, 0U) << refused.reasons;
}

}  // namespace
}  // namespace xview::test
