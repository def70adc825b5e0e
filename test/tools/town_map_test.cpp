// SPDX-License-Identifier: BSD-3-Clause
// Recordings, clouds and maps that are made, grown and compared.
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "support/test_data.h"
#include "tools/tiny_town.h"
#include "xview/io/pose_files.h"

namespace xview::test {
namespace {

namespace fs = std::filesystem;

TEST_F(TinyTown, LiftedCloudsRememberTheirClasses) {
  succeed({"lift", "-q", town("forward"), file("town.pcd")});
  succeed({"lift", "-q", town("rear"), file("rear.ply")});
  const Json of_folders =
      jsonLines(succeed({"localize", "-q", "--json", town("rear"), map()}).out).at(0);
  const Json of_clouds =
      jsonLines(succeed({"localize", "-q", "--json", file("rear.ply"), file("town.pcd")}).out)
          .at(0);
  const Eigen::Vector3d last_sensor =
      io::readPoses(town("rear") + "/poses.txt").back().T_frame_sensor.translation();
  EXPECT_LT((poseIn(of_clouds) * last_sensor - poseIn(of_folders) * last_sensor).norm(), 0.1);
}

TEST_F(TinyTown, WhatIsInAMapAlreadyIsSaid) {
  const std::string copy = file("again.xvm");
  fs::copy(map(), copy);
  const Outcome again = succeed({"map", "--append", town("forward"), copy});
  EXPECT_NE(again.err.find(" already; adding it once more"), std::string::npos) << again.err;
  fs::copy(map(), file("other.xvm"));
  const Outcome other = succeed({"map", "--append", town("rear"), file("other.xvm")});
  EXPECT_EQ(other.err.find(" already; adding it once more"), std::string::npos) << other.err;
  const Outcome learned =
      runXview({"learn", town("forward"), map(), file("own.txt")}, {120, 0, ""});
  EXPECT_EQ(learned.code, 1);
  EXPECT_NE(learned.err.find("is the drive that the map was made of"), std::string::npos)
      << learned.err;
}

TEST_F(TinyTown, RecordingsOfTwoFramesAreSaidAndThoseOfOneAreNot) {
  succeed({"localize", "-q", town("rear"), map(), "--matrix", file("T.txt")});
  std::istringstream numbers(readText(file("T.txt")));
  Eigen::Matrix<double, 4, 4, Eigen::RowMajor> T;
  for (double& number : T.reshaped<Eigen::RowMajor>()) numbers >> number;
  T(0, 3) += 4;
  std::ofstream(file("off.txt")) << T;
  const auto said = [&](const std::string& matrix) {
    succeed({"lift", "-q", town("rear"), "--transform", file(matrix), file("rear.pcd")});
    return succeed({"map", town("forward"), file("rear.pcd"), file("both.xvm")}).err;
  };
  EXPECT_EQ(said("T.txt").find("in one frame?"), std::string::npos);
  const std::string doubt = said("off.txt");
  EXPECT_NE(doubt.find(file("rear.pcd") + " does not fit " + town("forward")), std::string::npos)
      << doubt;
  T(0, 3) += 1000;
  std::ofstream(file("away.txt")) << T;
  const std::string away = said("away.txt");
  EXPECT_NE(away.find(" m away from " + town("forward") + "; are they in one frame?"),
            std::string::npos)
      << away;
}

TEST_F(TinyTown, ADriveFusedUnderAnotherNameIsSaid) {
  fs::copy(map(), file("fused.xvm"));
  succeed({"fuse", "-q", town("rear"), file("fused.xvm")});
  fs::copy(town("rear"), file("another"), fs::copy_options::recursive);
  const Outcome again = succeed({"fuse", file("another"), file("fused.xvm")});
  EXPECT_NE(again.err.find(" already; adding it once more"), std::string::npos) << again.err;
}

TEST_F(TinyTown, ScansAreReadBackAsScans) {
  const Outcome outcome = succeed({"info", "-q", town("lidar")});
  EXPECT_NE(outcome.out.find("semantic_kitti"), std::string::npos) << outcome.out;
}

TEST_F(TinyTown, FuseAddsInOnePieceAndUndoTakesItBack) {
  const std::string copy = file("copy.xvm");
  fs::copy_file(map(), copy);
  const auto vertices = [&] { return succeed({"graph", "-q", copy, file("copy.ply")}).out; };
  const std::string before = vertices();
  succeed({"fuse", "-q", town("rear"), copy});
  EXPECT_NE(vertices(), before);
  succeed({"fuse", "-q", "--undo", copy});
  EXPECT_EQ(vertices(), before);
  EXPECT_EQ(runXview({"fuse", "-q", "--undo", copy}).code, 1);
}

TEST_F(TinyTown, FusesAtOneTimeBothStay) {
  const std::string copy = file("shared.xvm");
  fs::copy_file(map(), copy);
  std::thread other([&] { succeed({"fuse", "-q", town("rear"), copy}); });
  succeed({"fuse", "-q", town("aerial"), copy});
  other.join();
  const std::string about = succeed({"info", copy}).out;
  for (const std::string& source : {town("forward"), town("rear"), town("aerial")})
    EXPECT_NE(about.find(source), std::string::npos) << about;
}

TEST_F(TinyTown, FuseLeavesTheMapAloneIfTheQueryIsNotAccepted) {
  const std::string bytes = readText(map());
  EXPECT_EQ(runXview({"fuse", "-q", town("elsewhere"), map()}).code, 3);
  EXPECT_TRUE(readText(map()) == bytes);
}

TEST_F(TinyTown, WhatIsLearnedIsNotWrittenOverTheMap) {
  const std::string bytes = readText(map());
  EXPECT_EQ(runXview({"learn", "-q", town("rear"), map(), map()}).code, 2);
  EXPECT_TRUE(readText(map()) == bytes);
}

TEST_F(TinyTown, AMapThatCannotBeWrittenIsToldBeforeTheWork) {
  const Outcome refused = runXview({"map", town("forward"), file("no such folder") + "/town.xvm"});
  EXPECT_EQ(refused.code, 1);
  EXPECT_EQ(lineCount(refused.err), 1u) << refused.err;
}

TEST_F(TinyTown, ARecordingThatDoesNotFitOntoTheDiskLeavesNothing) {
  Limits full;
  full.file_size_bytes = 2000;  // enough for poses, not for images
  const Outcome failed = runXview({"simulate", "-q", file("full"), "--route_length_m", "20",
                                   "--width", "160", "--height", "120"},
                                  full);
  EXPECT_EQ(failed.code, 1);
  EXPECT_EQ(lineCount(failed.err), 1u) << failed.err;
  EXPECT_FALSE(fs::exists(file("full")));
  fs::create_directories(file("kept"));
  runXview({"simulate", "-q", file("kept/town"), "--route_length_m", "20", "--width", "160",
            "--height", "120"},
           full);
  EXPECT_TRUE(fs::is_empty(file("kept")));
}

TEST_F(TinyTown, FuseIntoAnotherFileLeavesTheMapAlone) {
  const std::string bytes = readText(map()), larger = file("larger.xvm");
  succeed({"fuse", "-q", town("rear"), map(), "-o", larger});
  EXPECT_TRUE(readText(map()) == bytes);
  EXPECT_NE(succeed({"info", larger}).out.find(town("rear")), std::string::npos);
  fs::remove(larger);
  EXPECT_EQ(runXview({"fuse", "-q", town("elsewhere"), map(), "-o", larger}).code, 3);
  EXPECT_FALSE(fs::exists(larger));
}

TEST_F(TinyTown, LikelihoodsThatWereLearnedAreUsed) {
  const std::string table = file("learned.txt");
  const Outcome learned =
      succeed({"learn", "-q", town("rear"), town("aerial"), map(), table, "--length", "30"});
  EXPECT_NE(learned.out.find("samples at true poses"), std::string::npos) << learned.out;
  const auto scoreWith = [&](const std::vector<std::string>& flags) {
    std::vector<std::string> arguments{"localize", "-q", "--json", town("rear"), map()};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    return jsonLines(succeed(arguments).out).at(0)["hypotheses"][0]["score"].get<double>();
  };
  const double built_in = scoreWith({});
  EXPECT_NE(scoreWith({"--places.likelihoods", table}), built_in);
  EXPECT_EQ(runXview({"localize", town("rear"), map(), "--places.likelihoods", map()}).code, 1)
      << "a map is no table";
}

TEST_F(TinyTown, LearningNeedsTruePoses) {
  const std::string blind = file("blind");
  fs::copy(town("rear"), blind, fs::copy_options::recursive);
  fs::remove(blind + "/groundtruth.txt");
  const Outcome outcome = runXview({"learn", "-q", blind, map(), file("none.txt")});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.err.find("groundtruth.txt"), std::string::npos) << outcome.err;
  EXPECT_FALSE(fs::exists(file("none.txt")));
  succeed({"learn", "-q", blind, map(), file("none.txt"), "--length", "30", "--truth",
           town("rear") + "/groundtruth.txt"});
}

TEST_F(TinyTown, AVerdictIsLearnedFromAnswersThatSayAllItIsMadeOf) {
  const std::string answers = file("judged.jsonl"), model = file("verdict.txt");
  const Outcome found = runXview({"localize", "-q", "--json", town("rear"), town("elsewhere"),
                                  map(), "--window", "20", "--stride", "10"});
  writeText(answers, found.out);
  const Outcome learned = succeed({"learn", "--verdict", answers, model});
  const auto rights = static_cast<std::size_t>(std::stoi(learned.out.substr(model.size() + 2)));
  EXPECT_GE(rights, 2u) << learned.out;
  EXPECT_LT(rights, lineCount(found.out)) << learned.out;
  EXPECT_NE(readText(model).find("shown.log_margin "), std::string::npos);

  for (const std::string name : {"\"margin\":", "\"missing\":"}) {
    std::string older = found.out;
    const std::size_t at = older.find(name);
    ASSERT_NE(at, std::string::npos) << name;
    older.replace(at, name.size(), "\"other\":");
    writeText(answers, older);
    const Outcome refused = runXview({"learn", "--verdict", answers, file("older.txt")});
    EXPECT_EQ(refused.code, 1);
    EXPECT_NE(refused.err.find("localize again"), std::string::npos) << refused.err;
    EXPECT_FALSE(std::filesystem::exists(file("older.txt")));
  }
}

TEST_F(TinyTown, AShorterDriveInTheSameFolderLeavesNoOldFrames) {
  for (const char* length : {"20", "10"}) {
    succeed({"simulate", "-q", file("again"), "--route_length_m", length, "--width", "64",
             "--height", "48", "--sessions.rear=false", "--sessions.aerial=false"});
  }
  EXPECT_NE(succeed({"info", "-q", file("again/forward")}).out.find("frames        5,"),
            std::string::npos);
}

TEST_F(TinyTown, AppendingGrowsTheMapAndNotAppendingReplacesIt) {
  const std::string grown = file("grown.xvm");
  succeed({"map", "-q", town("forward"), "--frames", "0:20", grown});
  const auto keyframes = [&] { return succeed({"info", "-q", grown}).out; };
  const std::string first = keyframes();
  succeed({"map", "-q", "--append", town("forward"), "--frames", "20:40", grown});
  EXPECT_NE(keyframes(), first);
  succeed({"map", "-q", town("forward"), "--frames", "0:20", grown});
  EXPECT_EQ(keyframes(), first);
}

TEST_F(TinyTown, DiffComparesAVisitWithTheMap) {
  const Outcome outcome = succeed({"diff", map(), town("rear"), "-o", file("changes.csv")});
  EXPECT_EQ(outcome.out.find("0 gone, 0 new, 0 moved (of "), 0u) << outcome.out;
  EXPECT_EQ(readText(file("changes.csv")).rfind("change,class,dynamic,x,y,z,", 0), 0u);
  const std::string seen = outcome.out.substr(outcome.out.find("(of ") + 4);
  EXPECT_GT(std::stoi(seen), 3) << outcome.out;
  succeed({"diff", "-q", map(), town("rear"), "-o", file("changes.ply")});
  EXPECT_NE(readText(file("changes.ply")).find("element vertex"), std::string::npos);
  succeed({"diff", "-q", map(), town("rear"), "-o", file("changes.html")});
  EXPECT_NE(readText(file("changes.html")).find("seen by both"), std::string::npos);
}

TEST_F(TinyTown, DiffRefusesWhatItCannotCompare) {
  writeText(file("changes.csv"), "of an earlier visit");
  const Outcome elsewhere =
      runXview({"diff", map(), town("elsewhere"), "-o", file("changes.csv")}, {120, 0, ""});
  EXPECT_EQ(elsewhere.code, 3);
  EXPECT_NE(elsewhere.out.find("not found in the map, nothing is compared: "), std::string::npos);
  EXPECT_FALSE(fs::exists(file("changes.csv")));
  succeed({"graph", "-q", map(), file("bare.ply")});
  const Outcome bare = runXview({"diff", map(), file("bare.ply")}, {120, 0, ""});
  EXPECT_NE(bare.code, 0);
  EXPECT_EQ(runXview({"diff", map(), town("rear"), "-o", "changes.txt"}).code, 2);
}

}  // namespace
}  // namespace xview::test
