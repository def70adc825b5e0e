// SPDX-License-Identifier: BSD-3-Clause
// xview_mpi, which answers as xview does, with the search spread over ranks.
#ifdef XVIEW_MPI_PROGRAM
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <iterator>

#include "tools/tiny_town.h"

namespace xview::test {
namespace {

class Mpi : public TinyTown {
 protected:
  Mpi() {
    // Rank counts are those of the test, not of the machine, and containers have no other user.
    for (const char* name : {"OMPI_ALLOW_RUN_AS_ROOT", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM",
                             "OMPI_MCA_rmaps_base_oversubscribe"})
      setenv(name, "1", 0);
  }
  void SetUp() override {
    TinyTown::SetUp();
    const Outcome started = runProgram(XVIEW_MPIRUN, {"-n", "2", "true"}, {60, 0, ""});
    if (started.code != 0) GTEST_SKIP() << "mpirun starts nothing here: " << started.err;
  }
  /// On so many ranks; with one without mpirun.
  static Outcome onRanks(int ranks, std::vector<std::string> arguments) {
    if (ranks == 1) return runProgram(XVIEW_MPI_PROGRAM, arguments, {240, 0, ""});
    arguments.insert(arguments.begin(), {"-n", std::to_string(ranks), XVIEW_MPI_PROGRAM});
    return runProgram(XVIEW_MPIRUN, arguments, {240, 0, ""});
  }
  /// Of the other ranks, as -v says it.
  static int answersIn(const Outcome& outcome) {
    const std::size_t said = outcome.err.find("other ranks answered ");
    return said == std::string::npos ? -1 : std::atoi(outcome.err.c_str() + said + 21);
  }
  static std::vector<std::string> windows(const std::string& session) {
    return {"localize", "-q",       "--json", "--threads",   "1",  "--window",
            "12",       "--stride", "10",     town(session), map()};
  }
};

TEST_F(Mpi, AnswersAreThoseOfOneProcess) {
  for (const char* session : {"rear", "elsewhere"}) {
    const Outcome alone = runXview(windows(session), {240, 0, ""});
    const std::string expected = withoutTimes(alone.out);
    ASSERT_FALSE(expected.empty()) << alone.err;
    for (const int ranks : {1, 2, 4}) {
      const Outcome together = onRanks(ranks, windows(session));
      EXPECT_EQ(together.code, alone.code) << together.err;
      EXPECT_EQ(withoutTimes(together.out), expected) << ranks << " ranks";
    }
  }
}

TEST_F(Mpi, TheOtherRanksSearch) {
  std::vector<std::string> arguments = windows("rear");
  arguments[1] = "-v";
  for (const int ranks : {1, 3}) {
    const Outcome outcome = onRanks(ranks, arguments);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    const int requests = answersIn(outcome);
    EXPECT_TRUE(ranks == 1 ? requests == 0 : requests >= 2 * (ranks - 1)) << outcome.err;
  }
}

TEST_F(Mpi, MapsAreThoseOfOneProcessAndTheOtherRanksPreprocess) {
  const std::string expected = readText(map());
  const std::filesystem::directory_iterator images(town("forward") + "/depth");
  const auto frames = std::distance(begin(images), end(images));
  for (const int ranks : {1, 2, 4}) {
    const std::string made = file("town_" + std::to_string(ranks) + ".xvm");
    const Outcome outcome = onRanks(ranks, {"map", "-v", town("forward"), made});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(readText(made), expected) << ranks << " ranks";
    EXPECT_TRUE(ranks == 1 ? answersIn(outcome) == 0 : answersIn(outcome) > frames) << outcome.err;
  }
}

TEST_F(Mpi, WhatIsWrongIsSaidOnceAndEndsAllRanks) {
  const Outcome outcome = onRanks(3, {"map", "-q", file("absent"), file("none.xvm")});
  EXPECT_EQ(outcome.code, 1) << outcome.err;
  const std::size_t said = outcome.err.find("error: ");
  ASSERT_NE(said, std::string::npos) << outcome.err;
  EXPECT_EQ(outcome.err.find("error: ", said + 1), std::string::npos) << outcome.err;
}

TEST_F(Mpi, ARankThatDiesEndsTheJobAndTheOlderFileStays) {
  const auto besideOneThatDies = [](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"-n", "1", XVIEW_MPI_PROGRAM});
    arguments.insert(arguments.end(), {":", "-n", "1", "sh", "-c", "\"$0\" & sleep 0.5; kill -9 $!",
                                       XVIEW_MPI_PROGRAM});
    return runProgram(XVIEW_MPIRUN, arguments, {240, 0, ""});
  };
  const std::string answers = file("answers.jsonl"), older = file("older.xvm");
  writeText(answers, "older answers\n");
  writeText(older, readText(map()));
  const Outcome localized = besideOneThatDies(
      {"localize", "-q", "--window", "12", "--stride", "1", "-o", answers, town("rear"), map()});
  EXPECT_NE(localized.code, 0) << localized.out;
  const std::string left = readText(answers);
  EXPECT_TRUE(left == "older answers\n" || !jsonLines(left).empty()) << left;
  const Outcome mapped = besideOneThatDies({"map", "-q", town("rear"), town("forward"), older});
  EXPECT_NE(mapped.code, 0) << mapped.out;
  EXPECT_TRUE(readText(older) == readText(map())) << "an older map was changed";
}

}  // namespace
}  // namespace xview::test
#endif
