// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "support/program.h"
#include "support/test_data.h"
#include "xview/io/cloud_files.h"
#include "xview/io/image_files.h"
#include "xview/io/label_files.h"
#include "xview/io/pose_files.h"

namespace xview::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::vector<Json> jsonLines(const std::string& text) {
  std::vector<Json> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(Json::parse(line));
  return lines;
}

/// Answers without what the clock decides.
std::string timeless(const std::string& text) {
  std::string result;
  for (Json line : jsonLines(text)) {
    line.erase("timing_ms");
    result += line.dump() + "\n";
  }
  return result;
}

Outcome succeed(const std::vector<std::string>& arguments) {
  const Outcome outcome = runXview(arguments, {120, 0, ""});
  EXPECT_EQ(outcome.code, 0) << arguments[0] << ": " << outcome.err;
  return outcome;
}

Eigen::Isometry3d poseIn(const Json& answer) {
  Eigen::Matrix4d T;
  for (Eigen::Index i = 0; i < 16; ++i)
    T(i / 4, i % 4) = answer["T_map_query"][static_cast<std::size_t>(i)].get<double>();
  return Eigen::Isometry3d(T);
}

/// A tiny town, simulated and mapped once for all tests.
class TinyTown : public testing::Test {
 protected:
  static void SetUpTestSuite() {
#ifndef XVIEW_WITH_SIM
    GTEST_SKIP() << "this build has no simulator";
#endif
    folder_ = new TemporaryFolder;
    simulated_ =
        runXview({"simulate", "-q", town(""), "--seed", "5", "--route_length_m", "80", "--width",
                  "160", "--height", "120", "--sessions.elsewhere", "--sessions.lidar"},
                 {120, 0, ""});
    mapped_ = runXview({"map", "-q", town("forward"), map()}, {120, 0, ""});
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  static std::string town(const std::string& session) { return *folder_ / ("town/" + session); }
  static std::string map() { return *folder_ / "town.xvm"; }
  static std::string file(const std::string& name) { return *folder_ / name; }

  void SetUp() override {
    ASSERT_EQ(simulated_.code, 0) << simulated_.err;
    ASSERT_EQ(mapped_.code, 0) << mapped_.err;
  }

  static TemporaryFolder* folder_;
  static Outcome simulated_, mapped_;
};

TemporaryFolder* TinyTown::folder_ = nullptr;
Outcome TinyTown::simulated_, TinyTown::mapped_;

TEST_F(TinyTown, RearViewIsFoundWhereItIs) {
  const Outcome found = succeed({"localize", "-q", "--json", town("rear"), map()});
  writeText(file("rear.jsonl"), found.out);
  const std::string report = file("report");
  const Outcome judged = succeed(
      {"evaluate", "-q", file("rear.jsonl"), town("rear") + "/groundtruth.txt", "-o", report});
  EXPECT_NE(judged.out.find("1 queries: 1 accepted"), std::string::npos) << judged.out;
  const Json summary = Json::parse(readText(report + "/summary.json"));
  EXPECT_DOUBLE_EQ(summary["accepted_only"]["within_m"]["1"].get<double>(), 1) << judged.out;
  EXPECT_EQ(summary["covariance"]["answers"].get<int>(), 1);
  EXPECT_GT(summary["covariance"]["nees_over_6_mean"].get<double>(), 0);
  for (const char* name : {"results.csv", "pr.csv", "success.csv", "report.html"}) {
    EXPECT_GT(fs::file_size(report + "/" + name), 20u) << name;
  }
  const std::string blocked = file("blocked report");
  fs::create_directories(blocked + "/summary.json");
  EXPECT_EQ(runXview({"evaluate", "-q", file("rear.jsonl"), town("rear") + "/groundtruth.txt", "-o",
                      blocked})
                .code,
            1);
  EXPECT_EQ(std::distance(fs::directory_iterator(blocked), {}), 1) << "all files or none";
}

TEST_F(TinyTown, AnExplanationThatCannotBeWrittenIsToldBeforeTheSearch) {
  const Outcome refused = runXview({"localize", "--json", town("rear"), map(), "--explain",
                                    file("no such folder") + "/why.csv"});
  EXPECT_EQ(refused.code, 1);
  EXPECT_EQ(lineCount(refused.err), 1u) << refused.err;
}

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

TEST_F(TinyTown, AQueryThatNamesNoClassesTakesThoseOfTheMap) {
  const std::string nameless = file("nameless");
  fs::copy(town("rear"), nameless, fs::copy_options::recursive);
  fs::remove(nameless + "/classes.yaml");
  const Outcome found = succeed({"localize", "--json", nameless, map()});
  EXPECT_NE(found.err.find("names no classes; its ids are taken as those of the map"),
            std::string::npos)
      << found.err;
  std::string named = succeed({"localize", "-q", "--json", town("rear"), map()}).out;
  named.replace(named.find(town("rear")), town("rear").size(), nameless);
  EXPECT_EQ(timeless(found.out), timeless(named));
}

TEST_F(TinyTown, AQueryInOtherClassesIsFoundAndSaysWhatItTookThemFor) {
  // The same drive as another program would have saved it: other ids, other words, a class that the
  // map does not know.
  const std::string foreign = file("foreign");
  fs::copy(town("rear"), foreign, fs::copy_options::recursive);
  const LabelSet labels = io::readLabelSet(foreign + "/classes.yaml");
  const std::map<std::string, std::string> words = {{"road", "street"},
                                                    {"building", "static.house"},
                                                    {"vegetation", "Plants"},
                                                    {"pole", "utility_pole"},
                                                    {"traffic light", "gnomon"}};
  std::string classes = "name: foreign\nclasses:\n";
  for (const auto& [id, info] : labels.classes()) {
    const auto word = words.find(info.name);
    classes += "  - {id: " + std::to_string(100 - id) + ", name: \"" +
               (word == words.end() ? info.name : word->second) + "\"}\n";
  }
  writeText(foreign + "/classes.yaml", classes);
  for (const auto& entry : fs::directory_iterator(foreign + "/label")) {
    LabelImage image = io::readLabels(entry.path().string());
    for (std::uint16_t& label : image.pixels) label = static_cast<std::uint16_t>(100 - label);
    io::writeLabelPng(entry.path().string(), image);
  }
  const Outcome found = succeed({"localize", "--json", "--verbose", foreign, map()});
  EXPECT_NE(found.err.find("street is road in the map (by meaning)"), std::string::npos)
      << found.err;
  EXPECT_NE(found.err.find("gnomon (no such class in label set"), std::string::npos) << found.err;
  const Json named =
      jsonLines(succeed({"localize", "-q", "--json", town("rear"), map()}).out).at(0);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(jsonLines(found.out).at(0)["pose"]["position"][axis].get<double>(),
                named["pose"]["position"][axis].get<double>(), 0.1);
  }
  // As part of a map, too.
  succeed({"map", "-q", town("forward"), foreign, file("both.xvm")});

  writeText(file("words.txt"), "object light: gnomon, traffic light\n");
  const Outcome told =
      succeed({"localize", "--json", "--class-names", file("words.txt"), foreign, map()});
  EXPECT_EQ(told.err.find("gnomon (no such class"), std::string::npos) << told.err;
}

TEST_F(TinyTown, UnknownIdsAreSaidWithTheirShare) {
  const std::string odd = file("odd");
  fs::copy(town("rear"), odd, fs::copy_options::recursive);
  const std::string image = odd + "/label/000003.png";
  LabelImage labels = io::readLabels(image);
  std::fill(labels.pixels.begin(), labels.pixels.end(), std::uint16_t{77});
  io::writeLabelPng(image, labels);
  const Outcome found = succeed({"localize", "--json", odd, map()});
  EXPECT_NE(found.err.find("class 77 (label set"), std::string::npos) << found.err;
}

TEST_F(TinyTown, WhatIsInAMapAlreadyIsSaid) {
  const std::string copy = file("again.xvm");
  fs::copy(map(), copy);
  const Outcome again = succeed({"map", "--append", town("forward"), copy});
  EXPECT_NE(again.err.find("is in the map already"), std::string::npos) << again.err;
  fs::copy(map(), file("other.xvm"));
  const Outcome other = succeed({"map", "--append", town("rear"), file("other.xvm")});
  EXPECT_EQ(other.err.find("is in the map already"), std::string::npos) << other.err;
  const Outcome learned =
      runXview({"learn", town("forward"), map(), file("own.txt")}, {120, 0, ""});
  EXPECT_EQ(learned.code, 1);
  EXPECT_NE(learned.err.find("is the drive that the map was made of"), std::string::npos)
      << learned.err;
}

TEST_F(TinyTown, APriorOutsideOfTheMapIsTheReason) {
  const Outcome outside =
      runXview({"localize", "-q", "--json", "--near", "90000,0,10", town("rear"), map()});
  EXPECT_EQ(outside.code, 3);
  EXPECT_NE(jsonLines(outside.out)
                .at(0)["reason"]
                .get<std::string>()
                .find("the prior is outside of the map"),
            std::string::npos)
      << outside.out;
}

TEST_F(TinyTown, WithoutAnyClassNamesShapesTellStreetsFromThings) {
  for (const char* session : {"forward", "rear"}) {
    fs::copy(town(session), file(std::string("bare_") + session), fs::copy_options::recursive);
    fs::remove(file(std::string("bare_") + session) + "/classes.yaml");
  }
  const Outcome mapped = succeed({"map", file("bare_forward"), file("bare.xvm")});
  EXPECT_NE(mapped.err.find("as road"), std::string::npos) << mapped.err;
  EXPECT_NE(mapped.err.find("as pole"), std::string::npos) << mapped.err;
  const Json bare =
      jsonLines(succeed({"localize", "-q", "--json", file("bare_rear"), file("bare.xvm")}).out)
          .at(0);
  const Json named =
      jsonLines(succeed({"localize", "-q", "--json", town("rear"), map()}).out).at(0);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(bare["pose"]["position"][axis].get<double>(),
                named["pose"]["position"][axis].get<double>(), 0.3);
  }
}

TEST_F(TinyTown, AnswersAreDrawnWithTheWayOfTheQueryWhileItIsThere) {
  const std::string answers = file("drawn.jsonl"), page = file("drawn.html");
  fs::copy(town("rear"), file("moving"), fs::copy_options::recursive);
  writeText(answers, succeed({"localize", "-q", "--json", file("moving"), map()}).out);
  succeed({"view", "-q", map(), answers, "-o", page});
  const auto with_way = fs::file_size(page);
  fs::rename(file("moving"), file("moved"));
  succeed({"view", "-q", map(), answers, "-o", page});
  EXPECT_GT(with_way, fs::file_size(page) + 100);
}

TEST_F(TinyTown, AnswerHasTheKeysOfTheContractInOrder) {
  const Json answer =
      jsonLines(succeed({"localize", "-q", "--json", town("rear"), map()}).out).at(0);
  std::vector<std::string> keys;
  for (const auto& [key, value] : answer.items()) keys.push_back(key);
  const std::vector<std::string> expected{
      "query",          "status",      "reason",   "confidence", "witnesses",  "statistics",
      "size",           "T_map_query", "pose",     "covariance", "scale",      "gravity",
      "gravity_reason", "inliers",     "vertices", "matches",    "hypotheses", "timing_ms"};
  EXPECT_EQ(keys, expected);
  EXPECT_EQ(answer["query"]["input"], town("rear"));
  EXPECT_EQ(answer["query"]["first_frame"], 0);
  EXPECT_EQ(answer["query"]["last_frame"], answer["pose"]["frame"]);
  EXPECT_EQ(answer["T_map_query"].size(), 16u);
  EXPECT_EQ(answer["covariance"].size(), 36u);
  EXPECT_EQ(answer["pose"]["position"].size(), 3u);
  EXPECT_EQ(answer["pose"]["quaternion"].size(), 4u);
  EXPECT_EQ(answer["hypotheses"][0]["T_map_query"].size(), 16u);
  for (const char* stage : {"read", "lift", "blobs", "graph", "descriptors", "matching",
                            "rejection", "pose", "refine", "total", "load_map"}) {
    EXPECT_TRUE(answer["timing_ms"].contains(stage)) << stage;
  }
}

TEST_F(TinyTown, ThreadsDoNotChangeAByte) {
  for (const char* threads : {"1", "2"}) {
    const std::string t = threads;
    succeed({"lift", "-q", "--threads", t, town("rear"), file("lift" + t + ".pcd")});
    succeed({"blobs", "-q", "--threads", t, town("rear"), file("blobs" + t + ".pcd")});
    succeed({"graph", "-q", "--threads", t, town("rear"), file("graph" + t + ".ply")});
    succeed({"map", "-q", "--threads", t, town("rear"), file("map" + t + ".xvm")});
    writeText(file("fix" + t),
              timeless(runXview({"localize", "-q", "--json", "--threads", t, town("rear"),
                                 town("elsewhere"), map(), "--window", "20", "--stride", "10"})
                           .out));
  }
  for (const char* name : {"lift1.pcd", "blobs1.pcd", "graph1.ply", "map1.xvm", "fix1"}) {
    std::string other = name;
    other.replace(other.find('1'), 1, "2");
    EXPECT_FALSE(readText(file(name)).empty()) << name;
    EXPECT_TRUE(readText(file(name)) == readText(file(other))) << name << " differs from " << other;
  }
}

TEST_F(TinyTown, QueryFromElsewhereIsRefusedWithCodeThree) {
  const Outcome outcome = runXview({"localize", "-q", "--json", town("elsewhere"), map()});
  EXPECT_EQ(outcome.code, 3) << outcome.out;
  EXPECT_NE(jsonLines(outcome.out).at(0)["status"], "accepted");
}

TEST_F(TinyTown, WindowsAreQueriesOfTheirOwn) {
  const Outcome outcome = runXview({"localize", "-q", "--json", town("rear"), map(), "--window",
                                    "20", "--stride", "10", "--tum", file("a.tum")});
  const std::vector<Json> answers = jsonLines(outcome.out);
  ASSERT_GE(answers.size(), 3u);
  EXPECT_EQ(answers[1]["query"]["first_frame"], 10);
  EXPECT_EQ(answers[1]["query"]["last_frame"], 29);
  std::size_t accepted = 0;
  for (const Json& answer : answers) accepted += answer["status"] == "accepted";
  EXPECT_EQ(lineCount(readText(file("a.tum"))), accepted);
  EXPECT_EQ(outcome.code, accepted == answers.size() ? 0 : 3);
}

TEST_F(TinyTown, WithoutJsonThereIsALinePerQueryUnderAHeading) {
  const Outcome outcome = runXview({"localize", "-q", town("rear"), map(), "--window", "20"});
  EXPECT_EQ(outcome.out.rfind("  status ", 0), 0u) << outcome.out;
  EXPECT_EQ(outcome.out.find('\x1b'), std::string::npos) << "no colours in a pipe";
  EXPECT_EQ(lineCount(outcome.out), 3u) << outcome.out;
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

TEST_F(TinyTown, MatchesAreDrawnAlsoIfTheQueryIsNotAccepted) {
  const Outcome refused =
      runXview({"match", "-q", town("elsewhere"), map(), file("refused.ply")}, {120, 0, ""});
  EXPECT_EQ(refused.code, 3) << refused.err;
  EXPECT_EQ(readText(file("refused.ply")).rfind("ply\n", 0), 0u);
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

TEST_F(TinyTown, GraphIsAQueryAndAMap) {
  succeed({"graph", "-q", town("forward"), file("forward.ply")});
  const Outcome outcome =
      succeed({"localize", "-q", "--json", file("forward.ply"), file("forward.ply")});
  ASSERT_EQ(lineCount(outcome.out), 1u);
  EXPECT_TRUE(poseIn(jsonLines(outcome.out)[0]).isApprox(Eigen::Isometry3d::Identity(), 1e-3))
      << outcome.out;
}

TEST_F(TinyTown, PicturesAreWrittenByTheEndingOfTheirName) {
  succeed({"match", "-q", town("rear"), map(), file("match.ply")});
  EXPECT_EQ(readText(file("match.ply")).rfind("ply\n", 0), 0u);
  succeed({"match", "-q", town("rear"), map(), file("match.png")});
  EXPECT_EQ(readText(file("match.png")).substr(1, 3), "PNG");
  succeed({"view", "-q", map(), file("town.html")});
  EXPECT_NE(readText(file("town.html")).find("<html"), std::string::npos);
  succeed({"view", "-q", town("rear"), file("rear.pcd"), "--voxel", "0.5"});
  EXPECT_EQ(readText(file("rear.pcd")).rfind("# .PCD", 0), 0u);
}

std::size_t pointsOfClass(const std::string& pcd, const std::string& name) {
  const io::CloudHeader header = io::readCloudHeader(pcd);
  const LabelledCloud cloud = io::readCloud(pcd);
  std::size_t count = 0;
  for (const Point& p : cloud.points) count += header.labels->className(p.label) == name;
  return count;
}

TEST_F(TinyTown, CloudsOfMatchAndViewHoldMapQueryAndCorrespondences) {
  succeed({"lift", "-q", town("rear"), file("scan.pcd"), "--voxel", "0.3"});
  writeText(file("scan.jsonl"), succeed({"localize", "-q", "--json", file("scan.pcd"), map()}).out);
  succeed({"match", "-q", file("scan.pcd"), map(), file("match.pcd")});
  for (const char* name : {"road", "query, accepted", "kept correspondence", "pose, accepted"})
    EXPECT_GT(pointsOfClass(file("match.pcd"), name), 20u) << name;
  const auto viewed = [&](std::vector<std::string> files) {
    files.insert(files.begin(), {"view", "-q", "-o", file("view.pcd")});
    succeed(files);
    return readText(file("view.pcd"));
  };
  const std::string alone = viewed({map(), file("scan.jsonl")});
  EXPECT_GT(pointsOfClass(file("view.pcd"), "query, accepted"), 1000u);
  EXPECT_EQ(viewed({map(), file("scan.jsonl"), file("scan.pcd")}), alone)
      << "a scan beside its answer is drawn at its answer's pose, and once";
}

TEST_F(TinyTown, QueriesAreFoundFromTheFolderOfTheirAnswers) {
  const std::string relative = "rear";
  std::string answers = succeed({"localize", "-q", "--json", town("rear"), map()}).out;
  answers.replace(answers.find(town("rear")), town("rear").size(), relative);
  writeText(town("rear") + "/../beside.jsonl", answers);
  const Outcome drawn =
      runXview({"view", map(), town("rear") + "/../beside.jsonl", "-o", file("beside.pcd")});
  EXPECT_EQ(drawn.err.find("is not found"), std::string::npos) << drawn.err;
  EXPECT_GT(pointsOfClass(file("beside.pcd"), "query, accepted"), 1000u);
}

TEST_F(TinyTown, ACloudWithoutLabelsIsDrawnGrey) {
  writeText(file("bare.pcd"),
            "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 3\nHEIGHT 1\n"
            "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA ascii\n0 0 0\n1 0 0\n1 2 0\n");
  succeed({"view", "-q", file("bare.pcd"), "-o", file("grey.pcd")});
  EXPECT_EQ(pointsOfClass(file("grey.pcd"), "without label"), 3u);
}

TEST_F(TinyTown, TrajectoriesAreDrawnAndUnknownEndingsRefused) {
  const std::string way = file("drawn.tum");
  writeText(way, readText(town("rear") + "/groundtruth.txt"));
  succeed({"view", "-q", map(), way, "-o", file("drawn.html")});
  EXPECT_NE(readText(file("drawn.html")).find("\"name\":\"drawn.tum\""), std::string::npos);
  const Outcome refused = runXview({"view", map(), file("drawn.jpg")});
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("a drawing ends with .png"), std::string::npos) << refused.err;
}

TEST_F(TinyTown, TheTableOfAMatchHasALinePerPair) {
  const Outcome matched = succeed({"match", "-q", town("rear"), map(), file("pairs.csv")});
  std::istringstream lines(readText(file("pairs.csv")));
  std::size_t pairs = 0, kept = 0;
  std::string line;
  for (std::getline(lines, line); std::getline(lines, line); ++pairs) kept += line[0] == '1';
  EXPECT_NE(matched.out.find(std::to_string(pairs) + " putative correspondences, " +
                             std::to_string(kept) + " kept"),
            std::string::npos)
      << matched.out;
}

TEST_F(TinyTown, AFileOfJsonLeavesTheTableToTheTerminal) {
  const Outcome shown = succeed({"localize", town("rear"), map(), "-o", file("shown.jsonl")});
  EXPECT_NE(shown.out.find("accepted"), std::string::npos) << shown.out;
  EXPECT_EQ(Json::parse(readText(file("shown.jsonl")))["status"], "accepted");
  EXPECT_EQ(succeed({"localize", "-q", town("rear"), map(), "-o", file("shown.jsonl")}).out, "");
}

TEST_F(TinyTown, SeveralResultsAreJudgedTogether) {
  const std::string truth = town("rear") + "/groundtruth.txt", folder = file("together");
  succeed({"localize", "-q", town("rear"), map(), "-o", file("one.jsonl")});
  const Outcome judged =
      succeed({"evaluate", "-q", file("one.jsonl"), truth, file("one.jsonl"), truth, "-o", folder});
  EXPECT_EQ(judged.out.rfind("2 queries: 2 accepted", 0), 0u) << judged.out;
  for (const char* name : {"success.svg", "pr.svg", "calibration.svg"})
    EXPECT_EQ(readText(folder + "/" + name).rfind("<svg", 0), 0u) << name;
  EXPECT_EQ(runXview({"evaluate", file("one.jsonl"), truth, file("one.jsonl")}).code, 2);
}

TEST_F(TinyTown, InfoIsJsonForPrograms) {
  const Json drive = Json::parse(succeed({"info", "-q", "--json", town("rear")}).out);
  EXPECT_EQ(drive["kind"], "sequence");
  EXPECT_EQ(drive["frames"]["count"], io::readPoses(town("rear") + "/poses.txt").size());
  EXPECT_EQ(drive["bounds"].is_null(), true) << "a camera has positions";
  EXPECT_EQ(drive["positions"]["min"].size(), 3u);
  EXPECT_GT(drive["classes"].size(), 3u);
  EXPECT_EQ(succeed({"info", "-q", "--json", map(), "-o", file("map.json")}).out, "");
  const Json of_map = Json::parse(readText(file("map.json")));
  EXPECT_EQ(of_map["sources"], Json::array({town("forward")}));
  std::size_t vertices = 0;
  for (const Json& of_class : of_map["classes"]) vertices += of_class["count"].get<std::size_t>();
  EXPECT_EQ(of_map["graph"]["vertices"], vertices);
}

/// Check fix for: a last operand that existed was read, and the picture of the first written over.
TEST_F(TinyTown, ViewWritesOverNothingThatItWasNotToldToWrite) {
  const fs::path before = fs::current_path();
  fs::create_directories(file("here"));
  fs::current_path(file("here"));
  succeed({"lift", "-q", town("rear"), "--voxel", "0.5", "-o", "town.pcd"});
  const std::string cloud = readText("town.pcd");
  EXPECT_EQ(succeed({"view", "-q", map(), "town.pcd"}).out, "town.xvm.png\n");
  EXPECT_EQ(succeed({"view", "-q", "town.pcd"}).out, "town.pcd.png\n");
  EXPECT_TRUE(readText("town.pcd") == cloud);
  const Outcome refused = runXview({"view", "-q", map(), "town.pcd.png"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("-o town.pcd.png writes it anew"), std::string::npos) << refused.err;
  fs::current_path(before);
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

TEST_F(TinyTown, ExplanationsAddUpToTheScore) {
  const std::string csv = file("why.csv");
  const Outcome outcome = succeed({"localize", "-q", "--json", town("rear"), map(), "--explain",
                                   csv, "--refine.enabled", "false"});
  const Json answer = jsonLines(outcome.out).at(0);
  std::istringstream lines(readText(csv));
  std::string line, field;
  std::getline(lines, line);
  EXPECT_NE(line.find(answer["reason"].get<std::string>()), std::string::npos) << line;
  std::getline(lines, line);
  EXPECT_EQ(line.rfind("kind,name,testimony,x,y,z,nats,", 0), 0u) << line;
  double nats = 0;
  std::size_t samples = 0, vertices = 0;
  while (std::getline(lines, line)) {
    std::vector<std::string> fields;
    std::istringstream words(line);
    while (std::getline(words, field, ',')) fields.push_back(field);
    ASSERT_GE(fields.size(), 8u) << line;
    if (fields[0] == "vertex") ++vertices;
    if (fields[0] != "sample") continue;
    ++samples;
    const double value = std::stod(fields[6]);
    EXPECT_EQ(fields[2] == "contradicting", value < 0) << line;
    nats += value;
  }
  EXPECT_GT(samples, 100u);
  EXPECT_EQ(vertices, answer["inliers"].get<std::size_t>());
  const double score = answer["hypotheses"][0]["score"].get<double>();
  EXPECT_NEAR(nats, score, 0.02 * score);
  EXPECT_EQ(readText(file("why.ply")).rfind("ply\n", 0), 0u);
}

TEST_F(TinyTown, SeveralExplanationsNeedAFolder) {
  EXPECT_EQ(
      runXview({"localize", town("rear"), map(), "--window", "20", "--explain", "a.csv"}).code, 2);
  const std::string folder = file("whys");
  runXview({"localize", "-q", town("rear"), map(), "--window", "20", "--explain", folder});
  std::size_t files = 0;
  for (const auto& entry : fs::directory_iterator(folder))
    files += entry.path().extension() == ".csv";
  EXPECT_EQ(files, 2u);
}

TEST_F(TinyTown, ImageSpaceGoesThroughAllCommands) {
  const std::vector<std::string> image{"--graph_space", "image"};
  const auto with = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), image.begin(), image.end());
    return arguments;
  };
  const std::string of_images = file("image.xvm");
  succeed(with({"blobs", "-q", town("forward"), file("regions.pcd"), "--frames", "0:3"}));
  succeed(with({"graph", "-q", town("rear"), file("image.ply")}));
  EXPECT_NE(readText(file("image.ply")).find("comment graph_space image"), std::string::npos);
  succeed(with({"map", "-q", town("forward"), of_images}));
  EXPECT_NE(succeed({"info", "-q", of_images}).out.find("graph space   image"), std::string::npos);
  for (const std::string& against : {of_images, map()}) {
    const Outcome found =
        succeed(with({"localize", "-q", "--json", "--method", "walks", town("rear"), against}));
    writeText(file("image.jsonl"), found.out);
    const std::string truth = town("rear") + "/groundtruth.txt";
    const std::string report = file("image_report");
    succeed({"evaluate", "-q", file("image.jsonl"), truth, "-o", report});
    const Json summary = Json::parse(readText(report + "/summary.json"));
    EXPECT_DOUBLE_EQ(summary["accepted_only"]["within_m"]["5"].get<double>(), 1) << against;
  }
  const Outcome scans = runXview(with({"map", "-q", town("lidar"), file("scans.xvm")}));
  EXPECT_EQ(scans.code, 2) << scans.err;
  EXPECT_NE(scans.err.find("needs depth and label images"), std::string::npos) << scans.err;
  EXPECT_FALSE(fs::exists(file("scans.xvm")));
}

TEST_F(TinyTown, AShorterDriveInTheSameFolderLeavesNoOldFrames) {
  for (const char* length : {"20", "10"}) {
    succeed({"simulate", "-q", file("again"), "--route_length_m", length, "--width", "64",
             "--height", "48", "--sessions.rear=false", "--sessions.aerial=false"});
  }
  EXPECT_NE(succeed({"info", "-q", file("again/forward")}).out.find("frames        6,"),
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
  const Json json = Json::parse(
      succeed({"diff", "-q", map(), town("rear"), "--json", "-o", file("changes.ply")}).out);
  EXPECT_EQ(json["gone"], 0);
  EXPECT_GT(json["seen_by_both"], 3);
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
