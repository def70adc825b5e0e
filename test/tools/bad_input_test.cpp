// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "io/image_files.h"
#include "support/program.h"
#include "support/test_data.h"
#include "tools/sequence.h"

namespace xview::test {
namespace {

namespace fs = std::filesystem;

/// A good sequence to spoil, a map made of it, and a place for output that must not appear.
class BadInput : public testing::Test {
 protected:
  BadInput() { writeSequence(sequence_); }

  /// `map` of the spoilt sequence fails with one line that says `expected`, leaves no output, and
  /// an existing map as it was.
  void expectRefused(const std::string& expected) {
    expectFailure({"map", "-q", sequence_, output_}, expected);
    EXPECT_FALSE(fs::exists(output_));
    EXPECT_EQ(filesIn(folder_.path()), files_before_) << "something was left behind";
  }

  void expectFailure(const std::vector<std::string>& arguments, const std::string& expected) {
    files_before_ = filesIn(folder_.path());
    const Outcome outcome = runXview(arguments, {30, 2500, ""});
    EXPECT_EQ(outcome.code, 1) << outcome.err << " signal " << outcome.signal;
    EXPECT_EQ(lineCount(outcome.err), 1u) << outcome.err;
    EXPECT_EQ(outcome.err.rfind("error: ", 0), 0u) << outcome.err;
    EXPECT_NE(outcome.err.find(expected), std::string::npos) << outcome.err;
  }

  static std::size_t filesIn(const std::string& path) {
    std::size_t files = 0;
    for (const auto& entry : fs::recursive_directory_iterator(path))
      files += entry.is_regular_file();
    return files;
  }

  void makeMap() {
    const Outcome outcome = runXview({"map", "-q", sequence_, map_});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
  }

  TemporaryFolder folder_;
  std::string sequence_ = folder_ / "seq", output_ = folder_ / "new.xvm",
              map_ = folder_ / "town.xvm";
  std::size_t files_before_ = 0;
};

void replaceIn(const std::string& path, const std::string& from, const std::string& to) {
  std::string text = readText(path);
  const std::size_t at = text.find(from);
  ASSERT_NE(at, std::string::npos) << path << " has no " << from;
  writeText(path, text.replace(at, from.size(), to));
}

TEST_F(BadInput, GoodSequenceIsAccepted) { makeMap(); }

TEST_F(BadInput, MissingInput) {
  expectFailure({"map", "-q", folder_ / "nothing", output_}, "nothing");
}

/// What is spoilt in a good sequence, and what the one line says.
struct Spoilt {
  const char *file, *from, *to;  ///< text in the file; nothing to look for: all of it
  const char* expected;
};
constexpr const char* kGone = nullptr;  ///< in place of `to`
constexpr Spoilt kSpoilt[] = {
    {"label/000001.png", "", kGone, "label"},
    {"poses.txt", "", kGone, "poses.txt"},
    {"poses.txt", "", "0 0 0 0 0 0 0 1\n0.1 0 0 0 0 0 0 1\n", "poses.txt"},
    {"poses.txt", "",  // no rotation
     "1 0 0 0 0 2 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 0\n"
     "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 0\n",
     "poses.txt:1"},
    {"poses.txt", "1.5", "nan", "poses.txt:1"},
    {"camera.yaml", "fy: 40\n", "", "fy"},
    {"camera.yaml", "depth_scale: 0.01", "depth_scale: 0", "depth_scale"},
    {"camera.yaml", "depth_scale: 0.01", "depth_scale: 10", "depth_scale 10"},  // nothing in range
    {"camera.yaml", "depth_scale: 0.01", "depth_scale: 0.001", "10 times as large"},  // by motion
};

TEST_F(BadInput, WhatIsSpoiltIsNamed) {
  for (const Spoilt& spoilt : kSpoilt) {
    SCOPED_TRACE(std::string(spoilt.file) + ": " + (spoilt.to ? spoilt.to : "gone"));
    const std::string path = sequence_ + "/" + spoilt.file;
    if (!spoilt.to)
      fs::remove(path);
    else if (*spoilt.from)
      replaceIn(path, spoilt.from, spoilt.to);
    else
      writeText(path, spoilt.to);
    expectRefused(spoilt.expected);
    fs::remove_all(sequence_);
    writeSequence(sequence_);
  }
}

TEST_F(BadInput, DepthScalesAreWatchedByLiftAndBlobsToo) {
  const std::string cloud = folder_ / "new.pcd";
  for (const auto& [scale, complaint] :
       {std::pair{"10", "depth_scale 10"}, {"0.001", "10 times as large"}}) {
    writeSequence(sequence_);
    replaceIn(sequence_ + "/camera.yaml", "depth_scale: 0.01",
              std::string("depth_scale: ") + scale);
    expectFailure({"lift", "-q", sequence_, cloud}, complaint);
    expectFailure({"blobs", "-q", sequence_, cloud}, complaint);
    EXPECT_FALSE(fs::exists(cloud));
  }
}

TEST_F(BadInput, LabelsOfAnotherSizeThanDepth) {
  io::writeLabelPng(sequence_ + "/label/000002.png", LabelImage(32, 24, 3));
  expectRefused("000002.png");
}

TEST_F(BadInput, AllUnlabelled) {
  for (int i = 0; i < 4; ++i)
    io::writeLabelPng(sequence_ + "/label/00000" + std::to_string(i) + ".png",
                      LabelImage(64, 48, 0));
  expectRefused("seq");
}

/// Check fix for: a QUERY of which nothing is left was refused with code 3, as if it were
/// elsewhere.
TEST_F(BadInput, AQueryOfWhichNothingIsLeftIsAFailure) {
  makeMap();
  const std::string unlabelled = folder_ / "unlabelled", empty = folder_ / "empty.pcd";
  writeSequence(unlabelled);
  for (int i = 0; i < 4; ++i)
    io::writeLabelPng(unlabelled + "/label/00000" + std::to_string(i) + ".png",
                      LabelImage(64, 48, 200));
  writeText(empty,
            "VERSION .7\nFIELDS x y z label\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH "
            "0\nHEIGHT 1\nPOINTS 0\nDATA ascii\n");
  expectFailure({"localize", "-q", empty, map_}, "empty.pcd: it is empty");
  expectFailure({"localize", "-q", sequence_, empty}, "empty.pcd: it is empty");
  expectFailure({"localize", "-q", "--window", "2", unlabelled, map_}, "100 % class 200");
  const Outcome batch = runXview({"localize", "-q", "--json", empty, sequence_, map_});
  EXPECT_EQ(batch.code, 1);
  std::istringstream lines(batch.out);
  std::vector<std::vector<std::string>> keys;
  for (std::string line; std::getline(lines, line);) {
    const auto answer = nlohmann::json::parse(line).get<std::map<std::string, nlohmann::json>>();
    keys.emplace_back();
    for (const auto& [key, value] : answer) keys.back().push_back(key);
  }
  ASSERT_EQ(keys.size(), 2u) << batch.out;
  EXPECT_EQ(keys[0], keys[1]) << "a line of an error lacks keys";
}

TEST_F(BadInput, CloudInMillimetres) {
  std::string cloud =
      "VERSION .7\nFIELDS x y z label\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH "
      "100\nHEIGHT 1\nPOINTS 100\nDATA ascii\n";
  for (int i = 0; i < 100; ++i)
    cloud += std::to_string(700 * i) + " " + std::to_string(5000 * (i % 10)) + " " +
             std::to_string(300 * (i % 20)) + " 3\n";
  writeText(folder_ / "mm.pcd", cloud);
  makeMap();
  expectFailure({"map", "-q", folder_ / "mm.pcd", output_}, "millimetres");
  expectFailure({"localize", "-q", folder_ / "mm.pcd", map_}, "millimetres");
}

TEST_F(BadInput, TruncatedImage) {
  const std::string path = sequence_ + "/depth/000003.png", bytes = readText(path);
  writeText(path, bytes.substr(0, bytes.size() / 2));
  expectRefused("000003.png");
}

TEST_F(BadInput, ExistingMapSurvivesABadAddition) {
  makeMap();
  const std::string before = readText(map_);
  fs::remove(sequence_ + "/label/000001.png");
  expectFailure({"map", "-q", "--append", sequence_, map_}, "label");
  EXPECT_EQ(readText(map_), before);
}

TEST_F(BadInput, FileThatIsNoMapIsNotOverwritten) {
  writeText(output_, "my notes");
  expectFailure({"map", "-q", sequence_, output_}, "new.xvm");
  EXPECT_EQ(readText(output_), "my notes");
}

TEST_F(BadInput, FileThatIsNoMapIsNotOverwrittenByAMapOfAnotherEnding) {
  const std::string cloud = folder_ / "cloud.pcd";
  writeText(cloud, "my cloud");
  const Outcome outcome = runXview({"map", "-q", sequence_, cloud});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.err.find("cloud.pcd: a map ends with .xvm"), std::string::npos) << outcome.err;
  EXPECT_EQ(readText(cloud), "my cloud");
}

TEST_F(BadInput, WhatIsReadIsNotWrittenOver) {
  makeMap();
  const std::string cloud = folder_ / "cloud.pcd";
  ASSERT_EQ(runXview({"lift", "-q", sequence_, cloud}).code, 0);
  const std::string map = readText(map_), points = readText(cloud);
  fs::create_symlink(map_, folder_ / "link.xvm");
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"localize", sequence_, map_, "-o", map_},
        std::vector<std::string>{"localize", sequence_, map_, "--tum", folder_ / "link.xvm"},
        std::vector<std::string>{"localize", cloud, map_, "--matrix", cloud},
        std::vector<std::string>{"lift", cloud, cloud},
        std::vector<std::string>{"lift", cloud, "-o", cloud},
        std::vector<std::string>{"label", sequence_, sequence_}}) {
    const Outcome outcome = runXview(arguments);
    EXPECT_EQ(outcome.code, 2) << outcome.err;
    EXPECT_NE(outcome.err.find(" a path of its own"), std::string::npos) << outcome.err;
    EXPECT_TRUE(readText(map_) == map && readText(cloud) == points) << arguments[0];
  }
}

TEST_F(BadInput, SwappedQueryAndMapAreNamed) {
  makeMap();
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"localize", "-q", map_, sequence_},
        std::vector<std::string>{"localize", "-q", sequence_, map_, sequence_},
        std::vector<std::string>{"match", "-q", map_, sequence_, folder_ / "out.ply"},
        std::vector<std::string>{"fuse", "-q", map_, sequence_}}) {
    const Outcome outcome = runXview(arguments);
    EXPECT_EQ(outcome.code, 2) << arguments[0];
    EXPECT_EQ(outcome.out, "");
    EXPECT_NE(outcome.err.find("town.xvm is a map and " + sequence_ + " a recording"),
              std::string::npos)
        << outcome.err;
  }
}

TEST_F(BadInput, AMapIsFoundInItself) {
  makeMap();
  const Outcome outcome = runXview({"localize", "-q", map_, map_});
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
}

TEST_F(BadInput, AWindowLongerThanTheRecordingIsSaidToBeAllOfIt) {
  makeMap();
  const std::string note =
      "note: --window 9 is longer than " + sequence_ + ": its 4 frames are one query\n";
  const Outcome longer = runXview({"localize", "--window", "9", sequence_, map_});
  EXPECT_NE(longer.err.find(note), std::string::npos) << longer.err;
  const Outcome as_long = runXview({"localize", "--window", "4", sequence_, map_});
  EXPECT_EQ(as_long.err.find("is longer than"), std::string::npos) << as_long.err;
  const Outcome whole = runXview({"localize", sequence_, map_});
  EXPECT_EQ(whole.err.find("is longer than"), std::string::npos) << whole.err;
  for (const Outcome* outcome : {&longer, &as_long, &whole}) {
    EXPECT_EQ(lineCount(outcome->out), 2u) << outcome->out;  // heading and one query
    EXPECT_NE(outcome->out.find(" 0-3 "), std::string::npos) << outcome->out;
  }
}

TEST_F(BadInput, FileThatIsNoMapIsNoMapToLocalizeIn) {
  writeText(output_, "my notes");
  expectFailure({"localize", "-q", "--json", sequence_, output_}, "new.xvm");
}

TEST_F(BadInput, DamagedMap) {
  makeMap();
  const std::string bytes = readText(map_);
  writeText(map_, bytes.substr(0, bytes.size() / 2));
  expectFailure({"localize", "-q", "--json", sequence_, map_}, "town.xvm");
}

TEST_F(BadInput, MapOfAnotherLabelSet) {
  makeMap();
  writeText(sequence_ + "/classes.yaml",
            "- {id: 0, name: void}\n- {id: 2, name: road}\n- {id: 3, name: pole}\n- {id: 7, name: "
            "building}\n");
  const Outcome outcome = runXview({"localize", "-q", "--json", sequence_, map_});
  EXPECT_TRUE(outcome.code == 0 || outcome.code == 3) << "classes meet by name: " << outcome.err;
}

TEST_F(BadInput, OutputFolderDoesNotExist) {
  expectFailure({"lift", "-q", sequence_, folder_ / "no/such/cloud.pcd"}, "cloud.pcd");
}

TEST_F(BadInput, FullDisk) {
  fs::create_symlink("/dev/full", folder_ / "full.pcd");
  expectFailure({"lift", "-q", sequence_, folder_ / "full.pcd"}, "full.pcd");
}

TEST_F(BadInput, FullDiskUnderStandardOutput) {
  const Outcome outcome = runXview({"info", "-q", sequence_}, {30, 0, "/dev/full"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(lineCount(outcome.err), 1u) << outcome.err;
}

TEST_F(BadInput, CloudWithoutFinitePoints) {
  writeText(folder_ / "nan.pcd",
            "VERSION .7\nFIELDS x y z label\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH "
            "2\nHEIGHT 1\n"
            "POINTS 2\nDATA ascii\nnan nan nan 1\ninf 0 0 2\n");
  expectFailure({"blobs", "-q", folder_ / "nan.pcd", folder_ / "out.pcd"}, "nan.pcd");
  EXPECT_FALSE(fs::exists(folder_ / "out.pcd"));
}

TEST_F(BadInput, EmptyCloud) {
  writeText(folder_ / "empty.pcd",
            "VERSION .7\nFIELDS x y z label\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH "
            "0\nHEIGHT 1\n"
            "POINTS 0\nDATA ascii\n");
  for (const char* command : {"lift", "blobs", "map"}) {
    const std::string out =
        folder_ / (std::string("out") + (command == std::string("map") ? ".xvm" : ".pcd"));
    expectFailure({command, "-q", folder_ / "empty.pcd", out}, "empty.pcd");
    EXPECT_FALSE(fs::exists(out));
  }
}

TEST_F(BadInput, InABatchTheRestIsAnswered) {
  makeMap();
  const Outcome outcome =
      runXview({"localize", "-q", "--json", sequence_, folder_ / "nothing", sequence_, map_});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(lineCount(outcome.out), 3u);
  std::istringstream lines(outcome.out);
  std::vector<std::string> states;
  for (std::string line; std::getline(lines, line);) {
    const nlohmann::json answer = nlohmann::json::parse(line);
    states.push_back(answer["status"]);
    if (states.size() == 2) {
      EXPECT_EQ(answer["reason"], (folder_ / "nothing") + ": no such file or folder");
    }
  }
  EXPECT_EQ(states, (std::vector<std::string>{"accepted", "error", "accepted"}));
  EXPECT_EQ(lineCount(outcome.err), 1u) << outcome.err;
  EXPECT_NE(outcome.err.find("nothing"), std::string::npos) << outcome.err;
}

/// Check fix for: the heading of the table stood above no answer, and below the error.
TEST_F(BadInput, WithoutAnAnswerThereIsNoTable) {
  makeMap();
  const Outcome outcome = runXview({"localize", folder_ / "nothing", map_});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(outcome.out, "");
  const std::size_t last = outcome.err.rfind('\n', outcome.err.size() - 2) + 1;
  EXPECT_EQ(outcome.err.find("error: "), last) << outcome.err;
}

/// Check fix for: misuse that concerns one query only ended the batch, with code 2.
TEST_F(BadInput, InABatchTheRestIsAnsweredAfterAQueryThatIsMisusedAlone) {
  makeMap();
  const std::string cloud = folder_ / "cloud.pcd";
  ASSERT_EQ(runXview({"lift", "-q", sequence_, cloud}).code, 0);
  const Outcome outcome = runXview({"localize", "-q", "--json", "--method", "walks",
                                    "--graph_space", "image", cloud, sequence_, map_});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(lineCount(outcome.out), 2u) << outcome.out;
  EXPECT_EQ(lineCount(outcome.err), 1u) << outcome.err;
  EXPECT_NE(outcome.err.find("needs depth and label images"), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace xview::test
