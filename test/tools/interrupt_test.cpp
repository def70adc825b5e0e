// SPDX-License-Identifier: BSD-3-Clause
// Programs that are interrupted or killed: what they leave is old, new or absent, never a part that
// passes for a whole.
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>

#include "support/json_lines.h"
#include "support/program.h"
#include "support/test_data.h"
#include "tools/sequence.h"

namespace xview::test {
namespace {

namespace fs = std::filesystem;

class Interrupted : public testing::Test {
 protected:
  /// Regular files of this name and larger than so many bytes, anywhere in the folder.
  std::size_t filesNamed(const std::string& ending, std::uintmax_t bytes = 0) const {
    std::size_t count = 0;
    std::error_code failed;  // files come and go
    for (fs::recursive_directory_iterator entry(folder_.path(), failed), end; entry != end;
         entry.increment(failed)) {
      if (failed) return count;
      const std::string name = entry->path().filename().string();
      const bool fits = name.size() >= ending.size() &&
                        name.compare(name.size() - ending.size(), ending.size(), ending) == 0;
      count += fits && entry->is_regular_file(failed) && entry->file_size(failed) > bytes;
    }
    return count;
  }
  std::size_t partials() const {
    std::size_t count = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder_.path()))
      count += entry.path().filename().string().find(".partial-") != std::string::npos;
    return count;
  }

  TemporaryFolder folder_;
};

/// Check fix for: the folder stayed with some of its frames and was then taken for a recording.
TEST_F(Interrupted, LabelLeavesNoFolder) {
  const std::string input = folder_ / "raw", out = folder_ / "labelled";
  writeSequence(input, 120);
  fs::remove_all(input + "/label");
  const std::size_t before = filesNamed(".png");
  for (const int signal : {SIGINT, SIGTERM, SIGKILL}) {
    const Outcome outcome =
        runXview({"label", "-q", input, out},
                 {120, 0, "", 0, signal, [&] { return filesNamed(".png") > before + 4; }});
    ASSERT_FALSE(fs::exists(out)) << "signal " << signal << ", code " << outcome.code;
    if (signal == SIGKILL) {
      EXPECT_EQ(outcome.signal, SIGKILL);
      EXPECT_GT(partials(), 0u) << "killed too late to test anything";
    } else {
      EXPECT_EQ(outcome.code, 128 + signal) << outcome.err;
      EXPECT_EQ(outcome.err, "");
      EXPECT_EQ(partials(), 0u);
    }
  }
  const Outcome whole = runXview({"label", "-q", input, out});
  EXPECT_EQ(whole.code, 0) << whole.err;
  EXPECT_EQ(partials(), 0u) << "what the killed run left is still there";
  const Outcome info = runXview({"info", "-q", out});
  EXPECT_NE(info.out.find("120, numbers 0 .. 119"), std::string::npos) << info.out;
}

TEST_F(Interrupted, LabelLeavesTheRecordingThatWasThere) {
  const std::string input = folder_ / "raw", out = folder_ / "labelled";
  writeSequence(input, 120);
  writeSequence(out, 2);
  writeText(out + "/notes.txt", "mine");
  const std::string poses = readText(out + "/poses.txt");
  const std::size_t before = filesNamed(".png");
  const Outcome outcome =
      runXview({"label", "-q", input, out},
               {120, 0, "", 0, SIGTERM, [&] { return filesNamed(".png") > before + 4; }});
  EXPECT_EQ(outcome.code, 143) << outcome.err;
  EXPECT_EQ(readText(out + "/poses.txt"), poses);
  EXPECT_EQ(filesNamed(".png"), before);
  EXPECT_EQ(partials(), 0u);
  const Outcome whole = runXview({"label", "-q", input, out});
  EXPECT_EQ(whole.code, 0) << whole.err;
  EXPECT_EQ(readText(out + "/notes.txt"), "mine");
  EXPECT_EQ(runXview({"info", "-q", out}).code, 0);
}

#ifdef XVIEW_WITH_SIM
TEST_F(Interrupted, SimulateLeavesNoWorld) {
  const std::string out = folder_ / "worlds/town";
  for (const int signal : {SIGINT, SIGTERM, SIGKILL}) {
    const Outcome outcome = runXview(
        {"simulate", "-q", out, "--route_length_m", "84", "--width", "160", "--height", "120"},
        {120, 0, "", 0, signal, [&] { return filesNamed(".png") > 4; }});
    EXPECT_TRUE(signal == SIGKILL ? outcome.signal == signal : outcome.code == 128 + signal)
        << outcome.code << " " << outcome.err;
    EXPECT_EQ(outcome.out, "");
    ASSERT_FALSE(fs::exists(out)) << signal;
    EXPECT_EQ(filesNamed("") > 0, signal == SIGKILL);
  }
}
#endif

/// Check fix for: all answers so far were lost.
TEST_F(Interrupted, LocalizeKeepsTheAnswersSoFar) {
  const std::string input = folder_ / "seq", map = folder_ / "town.xvm";
  writeSequence(input, 60);
  ASSERT_EQ(runXview({"map", "-q", input, map}).code, 0);
  const std::string file = folder_ / "answers.jsonl";
  writeText(file, "older answers\n");
  const std::vector<std::string> windows = {"localize", "-q", "--window", "4",
                                            "--stride", "1",  input,      map};
  const auto expectWholeAnswers = [](const std::string& text) {
    ASSERT_FALSE(text.empty());
    EXPECT_EQ(text.back(), '\n');
    const std::vector<Json> answers = jsonLines(text);  // throws if one is cut off
    EXPECT_LT(answers.size(), 57u) << "interrupted too late to test anything";
    for (std::size_t i = 0; i < answers.size(); ++i)
      EXPECT_EQ(answers[i]["query"]["first_frame"], i);
  };
  std::vector<std::string> to_file = windows, to_stdout = windows;
  to_file.insert(to_file.end(), {"-o", file});
  to_stdout.emplace_back("--json");
  for (const int signal : {SIGINT, SIGTERM}) {
    const Outcome outcome =
        runXview(to_file, {120, 0, "", 0, signal, [&] {
                             for (const auto& e : fs::directory_iterator(folder_.path())) {
                               const std::string name = e.path().filename();
                               if (name.find("jsonl.partial-") != name.npos)
                                 return e.file_size() > 0;
                             }
                             return false;
                           }});
    EXPECT_EQ(outcome.code, 128 + signal) << outcome.err;
    expectWholeAnswers(readText(file));
    EXPECT_EQ(partials(), 0u);
    const std::string out = folder_ / "stdout";
    const Outcome printed =
        runXview(to_stdout, {120, 0, out, 0, signal, [&] { return !readText(out).empty(); }});
    EXPECT_EQ(printed.code, 128 + signal) << printed.err;
    expectWholeAnswers(readText(out));
  }
}

TEST_F(Interrupted, BeforeTheFirstAnswerTheOldFileStays) {
  const std::string input = folder_ / "seq", map = folder_ / "town.xvm";
  writeSequence(input, 4);
  ASSERT_EQ(runXview({"map", "-q", input, map}).code, 0);
  writeText(folder_ / "answers.jsonl", "older answers\n");
  const Outcome outcome = runXview({"localize", "-q", input, map, "-o", folder_ / "answers.jsonl"},
                                   {120, 0, "", 0, SIGTERM, [&] { return partials() > 0; }});
  if (outcome.code == 143) {
    EXPECT_EQ(readText(folder_ / "answers.jsonl"), "older answers\n");
  }
  EXPECT_EQ(partials(), 0u);
}

}  // namespace
}  // namespace xview::test
