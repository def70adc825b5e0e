// SPDX-License-Identifier: BSD-3-Clause
// --timeout and --max-memory: a query that takes more is an answer of its own kind.
#include "support/sanitizers.h"
#include "tools/tiny_town.h"

namespace xview::test {
namespace {

void expectCut(const Json& answer, const std::string& by) {
  EXPECT_EQ(answer["status"], "rejected");
  EXPECT_EQ(answer["budget_exhausted"], by) << answer;
  EXPECT_EQ(answer["reason"].get<std::string>().find("the " + by + " of "), 0u) << answer["reason"];
  EXPECT_TRUE(answer["hypotheses"].empty());
  EXPECT_TRUE(answer["pose"].is_null());
}

TEST_F(TinyTown, AQueryWhoseTimeEndsIsRejectedWithItsReason) {
  const Outcome cut = runXview(
      {"localize", "-q", "--json", "--timeout", "0.001", town("rear"), town("forward"), map()});
  EXPECT_EQ(cut.code, 3) << cut.err;
  const std::vector<Json> answers = jsonLines(cut.out);
  ASSERT_EQ(answers.size(), 2u);
  for (const Json& answer : answers) expectCut(answer, "time");
  EXPECT_EQ(answers[0]["query"]["last_frame"],
            jsonLines(succeed({"localize", "-q", "--json", town("rear"), map()})
                          .out)[0]["query"]["last_frame"]);
}

TEST_F(TinyTown, EveryWindowHasItsOwnTime) {
  for (const char* mode : {"--sequence", "--track", "--json"}) {
    const Outcome cut = runXview({"localize", "-q", "--json", mode, "--window", "10", "--timeout",
                                  "0.000001", town("rear"), map()});
    EXPECT_EQ(cut.code, 3) << cut.err;
    const std::vector<Json> answers = jsonLines(cut.out);
    EXPECT_GT(answers.size(), 1u);
    for (const Json& answer : answers) expectCut(answer, "time");
  }
}

TEST_F(TinyTown, ABudgetThatIsNotSpentChangesNothing) {
  const std::vector<std::string> plain = {"localize", "-q",         "--json", "--window",
                                          "20",       town("rear"), map()};
  std::vector<std::string> bounded = plain;
  bounded.insert(bounded.end(), {"--timeout", "1000", "--max-memory", "4000"});
  const std::string out = succeed(plain).out;
  EXPECT_EQ(out.find("budget_exhausted"), std::string::npos);
  EXPECT_EQ(withoutTimes(out), withoutTimes(succeed(bounded).out));
}

/// The memory that a query needs cannot be foretold, so that many bounds are tried: below some all
/// are cut, and none brings the program down.
TEST_F(TinyTown, AQueryWhoseMemoryEndsIsRejectedAndTheNextOneIsAnswered) {
  if (kSanitized) GTEST_SKIP() << "a sanitizer ends a program without memory";
  bool was_cut = false, was_answered = false;
  for (const char* megabytes : {"1", "4", "12", "20", "40", "60", "1000"}) {
    const Outcome run = runXview({"localize", "-q", "--json", "--max-memory", megabytes,
                                  town("rear"), town("forward"), map()});
    const std::vector<Json> answers = jsonLines(run.out);
    ASSERT_EQ(answers.size(), 2u) << megabytes << " MB: " << run.err;
    for (const Json& answer : answers) {
      was_cut |= answer.contains("budget_exhausted");
      was_answered |= answer["status"] == "accepted";
      if (answer["status"] != "accepted") expectCut(answer, "memory");
    }
  }
  EXPECT_TRUE(was_cut);
  EXPECT_TRUE(was_answered);
}

TEST_F(TinyTown, OtherCommandsAreBoundedAsWell) {
  const Outcome followed = runXview({"follow", "-q", "--timeout", "0.000001", town("rear"), map()});
  EXPECT_EQ(followed.code, 3) << followed.err;
  for (const Json& line : jsonLines(followed.out)) {
    EXPECT_EQ(line["state"], "searching");
    EXPECT_EQ(line["budget_exhausted"], "time");
  }
  for (const char* command : {"fuse", "diff"}) {
    const Outcome cut = runXview({command, "-q", "--timeout", "0.000001",
                                  std::string(command) == "fuse" ? town("rear") : map(),
                                  std::string(command) == "fuse" ? map() : town("rear")});
    EXPECT_EQ(cut.code, 3) << cut.err;
    EXPECT_NE(cut.out.find("the time of 1e-06 s ended in"), std::string::npos) << cut.out;
  }
  EXPECT_EQ(runXview({"localize", "--timeout", "-1", town("rear"), map()}).code, 2);
}

}  // namespace
}  // namespace xview::test
