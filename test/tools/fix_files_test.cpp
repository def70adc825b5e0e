// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <yaml-cpp/yaml.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "io/image_files.h"
#include "support/program.h"
#include "support/test_data.h"
#include "tools/tiny_town.h"
#include "xview/io/cloud_files.h"
#include "xview/io/recording.h"

namespace xview::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Lines of words, as any other program would read them.
std::vector<std::vector<std::string>> wordsOf(const std::string& path) {
  std::vector<std::vector<std::string>> lines;
  std::istringstream text(readText(path));
  for (std::string line; std::getline(text, line);) {
    std::istringstream words(line);
    lines.emplace_back();
    for (std::string word; words >> word;) lines.back().push_back(word);
  }
  return lines;
}

Eigen::Isometry3d poseOf(const std::vector<std::string>& words, std::size_t first) {
  double n[7];
  for (std::size_t i = 0; i < 7; ++i) n[i] = std::stod(words.at(first + i));
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::Quaterniond(n[6], n[3], n[4], n[5]).normalized().toRotationMatrix();
  T.translation() = Eigen::Vector3d(n[0], n[1], n[2]);
  return T;
}

std::vector<Eigen::Isometry3d> tumPoses(const std::string& path) {
  std::vector<Eigen::Isometry3d> poses;
  for (const auto& words : wordsOf(path)) {
    EXPECT_EQ(words.size(), 8u);
    poses.push_back(poseOf(words, 1));
  }
  return poses;
}

double distance(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return (a.translation() - b.translation()).norm();
}

/// A tiny town whose rear session is localized in windows once, with all files.
class FixFiles : public testing::Test {
 protected:
  static void SetUpTestSuite() {
#ifndef XVIEW_WITH_SIM
    GTEST_SKIP() << "this build has no simulator";
#endif
    folder_ = new TemporaryFolder;
    made_ = runXview(
        {"simulate", "-q", file("town"), "--seed", "5", "--route_length_m", "84", "--width", "160",
         "--height", "120", "--sessions.elsewhere", "--sessions.aerial=false"},
        {120, 0, ""});
    if (made_.code == 0) made_ = runXview({"map", "-q", file("town/forward"), map()}, {120, 0, ""});
    if (made_.code == 0) {
      found_ = runXview({"localize", "-q", "--json", rear(), map(), "--window", "20", "--stride",
                         "10", "--trajectory", file("way.tum"), "--matrix", file("T.txt")},
                        {120, 0, ""});
    }
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  void SetUp() override { ASSERT_EQ(made_.code, 0) << made_.err; }

  static std::string file(const std::string& name) { return *folder_ / name; }
  static std::string map() { return file("town.xvm"); }
  static std::string rear() { return file("town/rear"); }
  static std::string elsewhere() { return file("town/elsewhere"); }
  static std::vector<Json> answers(const std::string& text) {
    std::vector<Json> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) lines.push_back(Json::parse(line));
    return lines;
  }
  static std::vector<Json> accepted() {
    std::vector<Json> kept;
    for (const Json& answer : answers(found_.out)) {
      if (answer["status"] == "accepted") kept.push_back(answer);
    }
    return kept;
  }
  static std::size_t framesOfRear() { return tumPoses(rear() + "/groundtruth.txt").size(); }

  static TemporaryFolder* folder_;
  static Outcome made_, found_;
};

TemporaryFolder* FixFiles::folder_ = nullptr;
Outcome FixFiles::made_, FixFiles::found_;

TEST_F(FixFiles, TrajectoryHasEveryFrameWhereItWas) {
  const auto way = tumPoses(file("way.tum")), truth = tumPoses(rear() + "/groundtruth.txt");
  ASSERT_EQ(way.size(), truth.size());
  for (std::size_t i = 0; i < way.size(); ++i) EXPECT_LT(distance(way[i], truth[i]), 0.6) << i;
  const auto stamps = wordsOf(file("way.tum")), poses = wordsOf(rear() + "/poses.txt");
  for (std::size_t i = 0; i < way.size(); ++i)
    EXPECT_NEAR(std::stod(stamps[i][0]), std::stod(poses[i][0]), 1e-6);
}

TEST_F(FixFiles, TrajectoryGoesThroughTheAcceptedPoses) {
  const auto way = tumPoses(file("way.tum"));
  ASSERT_GE(accepted().size(), 2u);
  for (const Json& answer : accepted()) {
    const auto p = answer["pose"]["position"].get<std::vector<double>>();
    const auto frame = answer["query"]["last_index"].get<std::size_t>();
    EXPECT_LT((way[frame].translation() - Eigen::Vector3d(p[0], p[1], p[2])).norm(), 1e-6);
  }
}

/// What evo_ape prints for `tum groundtruth.txt way.tum` without alignment, in a few lines.
TEST_F(FixFiles, EvaluateJudgesATrajectoryAsEvoDoes) {
  const auto found = wordsOf(file("way.tum")), truth = wordsOf(rear() + "/groundtruth.txt");
  double squares = 0, sum = 0, worst = 0;
  int pairs = 0;
  for (const auto& pose : found) {
    for (const auto& true_pose : truth) {
      if (std::abs(std::stod(pose[0]) - std::stod(true_pose[0])) > 0.01) continue;
      double square = 0;
      for (std::size_t i = 1; i < 4; ++i)
        square += std::pow(std::stod(pose[i]) - std::stod(true_pose[i]), 2);
      squares += square;
      sum += std::sqrt(square);
      worst = std::max(worst, std::sqrt(square));
      ++pairs;
    }
  }
  ASSERT_EQ(static_cast<std::size_t>(pairs), found.size());
  const Outcome outcome = runXview(
      {"evaluate", "-q", file("way.tum"), rear() + "/groundtruth.txt", "-o", file("of_way")});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Json summary = Json::parse(readText(file("of_way/summary.json")))["accepted_only"];
  EXPECT_NEAR(summary["rmse_m"].get<double>(), std::sqrt(squares / pairs), 1e-9);
  EXPECT_NEAR(summary["mean_m"].get<double>(), sum / pairs, 1e-9);
  EXPECT_NEAR(summary["max_m"].get<double>(), worst, 1e-9);
}

TEST_F(FixFiles, MatrixIsTheTransformOfTheSurestWindow) {
  Json surest;
  for (const Json& answer : accepted()) {
    if (surest.is_null() || answer["confidence"] > surest["confidence"]) surest = answer;
  }
  const auto rows = wordsOf(file("T.txt"));
  ASSERT_EQ(rows.size(), 4u);
  const auto expected = surest["T_map_query"].get<std::vector<double>>();
  for (std::size_t i = 0; i < 16; ++i) {
    ASSERT_EQ(rows[i / 4].size(), 4u);
    EXPECT_EQ(std::stod(rows[i / 4][i % 4]), expected[i]) << i;
  }
}

/// Check fix for: a cloud that another program moved came back without its classes.
TEST_F(FixFiles, LiftMovesALabelledCloudByTheMatrixAndKeepsItsClasses) {
  ASSERT_EQ(runXview({"lift", "-q", rear(), "--voxel", "0.5", file("rear.pcd")}).code, 0);
  ASSERT_EQ(runXview({"lift", "-q", file("rear.pcd"), "--transform", file("T.txt"), "-o",
                      file("moved.pcd")})
                .code,
            0);
  Eigen::Matrix4d T;
  const auto rows = wordsOf(file("T.txt"));
  for (std::size_t i = 0; i < 16; ++i)
    T(static_cast<int>(i / 4), static_cast<int>(i % 4)) = std::stod(rows[i / 4][i % 4]);
  const LabelledCloud before = io::readCloud(file("rear.pcd")),
                      after = io::readCloud(file("moved.pcd"));
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    ASSERT_EQ(before.points[i].label, after.points[i].label);
    const Eigen::Vector3d expected = (T * before.position(i).homogeneous()).head<3>();
    ASSERT_LT((expected - after.position(i)).norm(), 1e-3) << i;
  }
  ASSERT_EQ(
      runXview({"lift", "-q", file("rear.pcd"), "--transform", file("T.txt"), file("moved.las")})
          .code,
      0);
  const LabelledCloud las = io::readCloud(file("moved.las"));
  ASSERT_EQ(las.size(), after.size());
  EXPECT_EQ(las.points.back().label, after.points.back().label);
  EXPECT_LT((las.position(9) - after.position(9)).norm(), 2e-3);
  ASSERT_EQ(runXview({"lift", "-q", rear(), file("rear.las")}).code, 0);
  EXPECT_EQ(io::openRecording(file("rear.las"))->labels(), io::openRecording(rear())->labels());
  EXPECT_EQ(io::readCloudHeader(file("moved.pcd")).labels->classes().size(),
            io::readCloudHeader(file("rear.pcd")).labels->classes().size());
  writeText(file("bent.txt"), "1 0 0 0\n0 2 0 0\n0 0 1 0\n0 0 0 1\n");
  const Outcome bent =
      runXview({"lift", file("rear.pcd"), "--transform", file("bent.txt"), "-o", file("bent.pcd")});
  EXPECT_EQ(bent.code, 1);
  EXPECT_NE(bent.err.find("bent.txt: expected a rotation"), std::string::npos) << bent.err;
}

TEST_F(FixFiles, WithoutAcceptedPoseWhatAnEarlierQueryLeftIsRemovedAndItIsSaid) {
  const std::vector<std::string> names{"no.tum", "no.txt", "no.yaml", "all.tum"};
  for (const std::string& name : names) writeText(file(name), "of an earlier query");
  for (const std::string& query : {elsewhere(), file("no such query")}) {
    const Outcome outcome =
        runXview({"localize", query, map(), "--trajectory", file("no.tum"), "--matrix",
                  file("no.txt"), "--initialpose", file("no.yaml"), "--tum", file("all.tum")});
    EXPECT_EQ(outcome.code, query == elsewhere() ? 3 : 1);
    for (const std::string& name : names) {
      EXPECT_FALSE(fs::exists(file(name))) << name;
      const bool was_there = query == elsewhere();
      EXPECT_EQ(
          outcome.err.find(file(name) + " of an earlier query is removed") != std::string::npos,
          was_there)
          << outcome.err;
    }
  }
}

TEST_F(FixFiles, InitialPoseIsTheLastAcceptedOne) {
  const Outcome outcome = runXview({"localize", "-q", "-o", file("ip.jsonl"), rear(), map(),
                                    "--window", "20", "--initialpose", file("ip.yaml")},
                                   {120, 0, ""});
  EXPECT_EQ(outcome.out, "");
  Json last;
  for (const Json& answer : answers(readText(file("ip.jsonl")))) {
    if (answer["status"] == "accepted") last = answer;
  }
  const YAML::Node message = YAML::LoadFile(file("ip.yaml"));
  EXPECT_EQ(message["header"]["frame_id"].as<std::string>(), "map");
  const YAML::Node pose = message["pose"]["pose"];
  int i = 0;
  for (const char* axis : {"x", "y", "z"})
    EXPECT_EQ(pose["position"][axis].as<double>(), last["pose"]["position"][i++].get<double>());
  double same = 0;  // q and -q are one attitude
  i = 0;
  for (const char* axis : {"x", "y", "z", "w"})
    same += pose["orientation"][axis].as<double>() * last["pose"]["quaternion"][i++].get<double>();
  EXPECT_NEAR(std::abs(same), 1, 1e-9);
  EXPECT_EQ(message["pose"]["covariance"].as<std::vector<double>>(),
            last["covariance"].get<std::vector<double>>());
}

TEST_F(FixFiles, InitialPoseIsThatOfTheBaseIfItIsToldWhereThatIs) {
  const auto poseOfAll = [&](const std::vector<std::string>& flags) {
    std::vector<std::string> arguments = {"localize",       "-q", rear(), map(), "--initialpose",
                                          file("base.yaml")};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    succeed(arguments);
    const YAML::Node pose = YAML::LoadFile(file("base.yaml"))["pose"]["pose"];
    std::vector<std::string> words;
    for (const char* axis : {"x", "y", "z"})
      words.push_back(pose["position"][axis].as<std::string>());
    for (const char* axis : {"x", "y", "z", "w"})
      words.push_back(pose["orientation"][axis].as<std::string>());
    return poseOf(words, 0);
  };
  const Eigen::Isometry3d sensor = poseOfAll({});
  EXPECT_NE(readText(file("base.yaml")).find("# pose of the sensor"), std::string::npos);
  const Eigen::Isometry3d base = poseOfAll({"--T_sensor_base", "0.5,1,-2,0,0,90"});
  const Eigen::Isometry3d T_sensor_base = sensor.inverse() * base;
  EXPECT_LT((T_sensor_base.translation() - Eigen::Vector3d(0.5, 1, -2)).norm(), 1e-6);
  EXPECT_LT((T_sensor_base.linear() * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(),
            1e-6);
  EXPECT_EQ(runXview({"localize", rear(), map(), "--T_sensor_base", "1,2"}).code, 2);
}

/// Somebody carries the robot in the middle of the recording, and its odometry jumps.
TEST_F(FixFiles, TrajectoryHasNoPoseWhereOdometryDoesNotConnectFixes) {
  const std::string carried = file("carried");
  fs::copy(rear(), carried, fs::copy_options::recursive);
  const auto odometry = wordsOf(carried + "/poses.txt");
  std::string jumped;
  for (std::size_t i = 0; i < odometry.size(); ++i) {
    for (std::size_t k = 0; k < odometry[i].size(); ++k) {
      const bool moves = k == 1 && i >= odometry.size() / 2;
      jumped += (moves ? std::to_string(std::stod(odometry[i][k]) + 900) : odometry[i][k]) + " ";
    }
    jumped += "\n";
  }
  writeText(carried + "/poses.txt", jumped);
  const Outcome outcome = succeed({"localize", carried, map(), "--window", "10", "--stride", "5",
                                   "--trajectory", file("carried.tum")});
  EXPECT_NE(outcome.err.find("--trajectory has no pose between stamps"), std::string::npos)
      << outcome.err;
  const auto truth = wordsOf(rear() + "/groundtruth.txt"), way = wordsOf(file("carried.tum"));
  ASSERT_LT(way.size(), truth.size());
  ASSERT_GT(way.size(), truth.size() / 4);
  std::size_t next = 0;
  for (const auto& words : way) {
    while (next < truth.size() && std::stod(truth[next][0]) + 1e-6 < std::stod(words[0])) ++next;
    ASSERT_LT(next, truth.size());
    EXPECT_LT(distance(poseOf(words, 1), poseOf(truth[next], 1)), 1) << words[0];
  }
}

TEST_F(FixFiles, WhatCannotBeWrittenIsSaidBeforeTheWork) {
  const Outcome outcome =
      runXview({"localize", "-q", rear(), map(), "--matrix", file("no/such/T.txt")});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(outcome.out, "");
  EXPECT_NE(outcome.err.find("T.txt"), std::string::npos) << outcome.err;
}

TEST_F(FixFiles, SequenceSaysWhatTheWindowsSayTogether) {
  const Outcome outcome = runXview(
      {"localize", "-q", "--json", rear(), map(), "--window", "10", "--sequence"}, {120, 0, ""});
  const auto lines = answers(outcome.out);
  ASSERT_GE(lines.size(), 3u) << outcome.err;
  EXPECT_EQ(lines[0]["sequence"]["windows"], 1);
  EXPECT_EQ(lines[2]["sequence"]["windows"], 3);
  EXPECT_GT(lines[2]["sequence"]["score"], lines[0]["sequence"]["score"]);
  EXPECT_TRUE(lines[2]["sequence"]["alone"].contains("status"));
}

TEST_F(FixFiles, TrackSaysWhereItSearched) {
  const Outcome outcome = runXview(
      {"localize", "-q", "--json", rear(), map(), "--window", "20", "--stride", "10", "--track"},
      {120, 0, ""});
  const auto lines = answers(outcome.out);
  ASSERT_GE(lines.size(), 3u) << outcome.err;
  EXPECT_EQ(lines[0]["track"]["searched"], "everywhere");
  EXPECT_EQ(lines[1]["track"]["searched"], "expected");
  EXPECT_GT(lines[1]["track"]["radius_m"], 0);
}

TEST_F(FixFiles, ScaleAndGravityAreSaid) {
  const Outcome plain = runXview({"localize", "-q", "--json", rear(), map()}, {120, 0, ""});
  const auto as_is = answers(plain.out);
  ASSERT_EQ(as_is.size(), 1u) << plain.err;
  EXPECT_EQ(as_is[0]["scale"], 1.0);
  EXPECT_EQ(as_is[0]["gravity"], "aligned");
  EXPECT_NE(as_is[0]["gravity_reason"].get<std::string>().find("z is up"), std::string::npos);
  const Outcome free = runXview({"localize", "-q", "--json", "--gravity", "free", "--scale",
                                 "0.95,1.05", rear(), map(), "--matrix", file("free.txt")},
                                {120, 0, ""});
  const auto found = answers(free.out);
  ASSERT_EQ(found.size(), 1u) << free.err;
  EXPECT_EQ(found[0]["gravity"], "levelled");
  const double scale = found[0]["scale"].get<double>();
  EXPECT_NEAR(scale, 1, 0.02);
  const auto rows = wordsOf(file("free.txt"));
  Eigen::Matrix3d R;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 3; ++k)
      R(static_cast<int>(i), static_cast<int>(k)) = std::stod(rows[i][k]);
  EXPECT_NEAR(std::cbrt(R.determinant()), scale, 1e-9) << "lengths of the query become the map's";
  EXPECT_EQ(runXview({"localize", "-q", rear(), map(), "--scale", "big"}).code, 2);
  EXPECT_EQ(runXview({"localize", "-q", rear(), map(), "--gravity", "down"}).code, 2);
  EXPECT_EQ(
      runXview({"localize", "-q", rear(), map(), "--window", "10", "--track", "--scale", "free"})
          .code,
      2);
}

TEST_F(FixFiles, ALongRecordingIsFoundByItsEnd) {
  const auto localized = [&](const std::string& last_m) {
    const Outcome outcome = runXview({"localize", "-q", "--json", rear(), map(), "--last", last_m,
                                      "--trajectory", file("long.tum")});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return Json::parse(outcome.out);
  };
  const Json whole = localized("0")["query"], end = localized("30")["query"];
  const auto odometry = tumPoses(rear() + "/poses.txt");
  EXPECT_EQ(whole["used_from_index"], 0);
  const auto used = end["used_from_index"].get<std::size_t>();
  double used_m = 0;
  for (std::size_t i = used + 1; i < odometry.size(); ++i)
    used_m += distance(odometry[i - 1], odometry[i]);
  const double one_more_m = distance(odometry[used - 1], odometry[used]);
  EXPECT_LE(used_m, 30);
  EXPECT_GT(used_m + one_more_m, 30);
  EXPECT_EQ(end["first_frame"], whole["first_frame"]) << "the query is still all of it";
  EXPECT_EQ(end["last_index"], whole["last_index"]);
  const auto way = tumPoses(file("long.tum")), truth = tumPoses(rear() + "/groundtruth.txt");
  ASSERT_EQ(way.size(), truth.size()) << "frames before take part in the trajectory";
  for (std::size_t i = 0; i < way.size(); ++i) EXPECT_LT(distance(way[i], truth[i]), 0.6) << i;
  EXPECT_EQ(runXview({"localize", "-q", rear(), map(), "--last", "-1"}).code, 2);
}

/// Check fix for: what lay behind the last window that was found had poses by odometry alone,
/// whatever it did there.
TEST_F(FixFiles, TrajectoryHasNoPoseBeyondWhatWasFound) {
  const std::string blind = file("blind");
  fs::copy(rear(), blind, fs::copy_options::recursive);
  const std::size_t frames = framesOfRear(), seen = frames / 2 / 10 * 10;
  std::vector<fs::path> images;
  for (const auto& entry : fs::directory_iterator(blind + "/label")) images.push_back(entry.path());
  std::sort(images.begin(), images.end());
  ASSERT_EQ(images.size(), frames);
  for (std::size_t i = seen; i < frames; ++i) io::writeLabelPng(images[i], LabelImage(160, 120, 0));
  succeed({"localize", blind, map(), "--window", "10", "--stride", "10", "--trajectory",
           file("blind.tum")});
  const auto way = tumPoses(file("blind.tum"));
  EXPECT_LE(way.size(), seen);
  EXPECT_GE(way.size(), seen / 2);
}

TEST_F(FixFiles, TheWayOfAnAnswerIsDrawnInItsScale) {
  Json answer = accepted().at(0);
  const auto drawn = [&](double scale) {
    answer["scale"] = scale;
    writeText(file("scaled.jsonl"), answer.dump() + "\n");
    EXPECT_EQ(runXview({"view", "-q", map(), file("scaled.jsonl"), "-o", file("way.png")}).code, 0);
    return readText(file("way.png"));
  };
  EXPECT_NE(drawn(1), drawn(3));
  answer["scale"] = -1;
  writeText(file("scaled.jsonl"), answer.dump() + "\n");
  EXPECT_EQ(runXview({"view", "-q", map(), file("scaled.jsonl"), "-o", file("way.png")}).code, 1);
}

/// Check fix for: a mesh showed the map alone.
TEST_F(FixFiles, MeshesShowAnswersToo) {
  writeText(file("one.jsonl"), accepted().at(0).dump() + "\n");
  for (const char* ending : {"ply", "vtk"}) {
    const std::string alone = file(std::string("alone.") + ending);
    const std::string with_answer = file(std::string("with_answer.") + ending);
    EXPECT_EQ(runXview({"view", "-q", map(), alone}).code, 0);
    EXPECT_EQ(runXview({"view", "-q", map(), file("one.jsonl"), with_answer}).code, 0);
    EXPECT_GT(fs::file_size(with_answer), fs::file_size(alone)) << ending;
  }
}

TEST_F(FixFiles, NearAndYawAreThePriorsByAShorterName) {
  const Eigen::Vector3d truth = tumPoses(rear() + "/groundtruth.txt").back().translation();
  const auto circle = [&](double dx) {
    return std::to_string(truth.x() + dx) + "," + std::to_string(truth.y()) + ",10";
  };
  EXPECT_EQ(runXview({"localize", "-q", rear(), map(), "--near", circle(0)}).code, 0);
  EXPECT_EQ(runXview({"localize", "-q", rear(), map(), "--near", circle(40)}).code, 3);
  EXPECT_EQ(runXview({"localize", "-q", rear(), map(), "--near", "1,2"}).code, 2);
  EXPECT_EQ(runXview({"localize", "-q", rear(), map(), "--yaw", "north,5"}).code, 2);
}

}  // namespace
}  // namespace xview::test
