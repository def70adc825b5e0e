// SPDX-License-Identifier: BSD-3-Clause
// xview follow: frames of a recording, of standard input, of a folder that fills.
#include <gtest/gtest.h>

#include <fmt/core.h>
#include <sys/stat.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <thread>

#include "tools/tiny_town.h"
#include "xview/io/cloud_files.h"
#include "xview/io/pose_files.h"

namespace xview::test {
namespace {

namespace fs = std::filesystem;

class Follow : public TinyTown {
 protected:
  static Eigen::Vector3d positionIn(const Json& line) {
    const Json& p = line["pose"]["position"];
    return {p[0].get<double>(), p[1].get<double>(), p[2].get<double>()};
  }
  static std::vector<io::StampedPose> truthOf(const std::string& session) {
    return io::readPoses(town(session) + "/groundtruth.txt");
  }
  /// "stamp tx ty tz qx qy qz qw"
  static std::string poseLine(double stamp_s, const Eigen::Isometry3d& T) {
    const Eigen::Vector3d p = T.translation();
    const Eigen::Quaterniond q(T.linear());
    return fmt::format("{} {} {} {} {} {} {} {}", stamp_s, p.x(), p.y(), p.z(), q.x(), q.y(), q.z(),
                       q.w());
  }
  static std::string scan(const std::string& session, std::size_t i) {
    return town(session) + fmt::format("/velodyne/{:06}.bin", i);
  }
  static void expectRightPosesThough(bool odometry_jumps);
  /// Runs it with a file as its standard input.
  static Outcome followLines(const std::string& lines, const std::string& flags) {
    writeText(file("lines.txt"), lines);
    return runProgram("/bin/sh",
                      {"-c", fmt::format("'{}' follow -q {} - '{}' < '{}'", XVIEW_PROGRAM, flags,
                                         map(), file("lines.txt"))},
                      {120, 0, ""});
  }
};

TEST_F(Follow, ARecordingHasOneLinePerFrameAndPosesWhereItWas) {
  const Outcome outcome =
      runXview({"follow", town("rear"), map(), "--window", "20", "--initialpose", file("now.yaml")},
               {120, 0, ""});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const auto truth = truthOf("rear");
  const std::vector<Json> lines = jsonLines(outcome.out);
  ASSERT_EQ(lines.size(), truth.size());
  std::size_t posed = 0, predicted = 0;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const Json& line = lines[i];
    EXPECT_EQ(line["frame"], i);
    EXPECT_GT(line["latency_ms"].get<double>(), 0);
    EXPECT_EQ(line["pose"].is_null(), line["state"] != "found") << line;
    if (line["pose"].is_null()) continue;
    ++posed;
    predicted += line["source"] == "odometry";
    EXPECT_LT((positionIn(line) - truth[i].T_frame_sensor.translation()).norm(), 1) << line;
    EXPECT_EQ(line["covariance"].size(), 36u);
    if (line["source"] == "odometry" && lines[i - 1]["source"] == "fix") {
      EXPECT_GT(line["covariance"][0].get<double>(), lines[i - 1]["covariance"][0].get<double>());
    }
  }
  EXPECT_GT(posed, truth.size() / 3);
  EXPECT_GT(predicted, posed / 2);
  EXPECT_EQ(fs::exists(file("now.yaml")), lines.back()["state"] == "found");
}

TEST_F(Follow, AMapIsNoFrame) {
  const Outcome swapped = runXview({"follow", map(), town("rear")});
  EXPECT_EQ(swapped.code, 2);
  EXPECT_NE(swapped.err.find("the map comes last"), std::string::npos) << swapped.err;
  EXPECT_EQ(swapped.out, "");
}

TEST_F(Follow, AnotherTownNeverGetsAPose) {
  writeText(file("stale.yaml"), "of an earlier run");
  const Outcome outcome = runXview({"follow", "-q", town("elsewhere"), map(), "--window", "20",
                                    "--initialpose", file("stale.yaml")},
                                   {120, 0, ""});
  EXPECT_EQ(outcome.code, 3) << outcome.err;
  for (const Json& line : jsonLines(outcome.out)) {
    EXPECT_EQ(line["state"], "searching");
    EXPECT_TRUE(line["pose"].is_null()) << line;
  }
  EXPECT_FALSE(fs::exists(file("stale.yaml")));
}

/// After a third of the drive the robot is carried to another town, and from there to the last
/// third. It is lost there, found on both sides, and every pose that is said is right.
void Follow::expectRightPosesThough(bool odometry_jumps) {
  const auto truth = truthOf("lidar_reverse"), strange = truthOf("lidar_elsewhere");
  const std::size_t third = truth.size() / 3, strangers = 4;
  std::string text = "# frames of a scanner\n\n";
  std::vector<std::optional<Eigen::Vector3d>> positions;
  Eigen::Isometry3d T_odom_sensor = Eigen::Isometry3d::Identity();
  const auto drive = [&](const std::string& session, const std::vector<io::StampedPose>& poses,
                         std::size_t first, std::size_t last) {
    // Without a jump the odometry goes on as if nobody had carried the robot.
    if (odometry_jumps) T_odom_sensor.pretranslate(Eigen::Vector3d(500, -200, 3));
    const Eigen::Isometry3d T_odom_map = T_odom_sensor * poses[first].T_frame_sensor.inverse();
    for (std::size_t i = first; i < last; ++i) {
      T_odom_sensor = T_odom_map * poses[i].T_frame_sensor;
      const double stamp_s = 100 + 0.5 * static_cast<double>(positions.size());
      text += scan(session, i) + " " + poseLine(stamp_s, T_odom_sensor) + "\n";
      if (&poses == &truth)
        positions.emplace_back(poses[i].T_frame_sensor.translation());
      else
        positions.emplace_back();
    }
  };
  drive("lidar_reverse", truth, 0, third);
  drive("lidar_elsewhere", strange, 0, strangers);
  drive("lidar_reverse", truth, 2 * third, truth.size());
  const Outcome outcome = followLines(text, "");
  ASSERT_EQ(outcome.code, 0) << outcome.err << outcome.out.substr(0, 2000);
  const std::vector<Json> lines = jsonLines(outcome.out);
  ASSERT_EQ(lines.size(), positions.size());
  EXPECT_EQ(lines[3]["stamp"], 101.5);
  for (std::size_t k = 0; k < lines.size(); ++k) {
    ASSERT_EQ(lines[k]["pose"].is_null(), lines[k]["state"] != "found") << lines[k];
    if (!positions[k]) {
      EXPECT_EQ(lines[k]["state"], "lost") << lines[k];
    } else if (!lines[k]["pose"].is_null()) {
      EXPECT_LT((positionIn(lines[k]) - *positions[k]).norm(), 1) << lines[k];
    }
  }
  const auto jumps = std::count_if(lines.begin(), lines.end(),
                                   [](const Json& line) { return line.contains("jump_m"); });
  EXPECT_EQ(jumps, 1);
  EXPECT_EQ(lines[third - 1]["state"], "found") << lines[third - 1];
  EXPECT_EQ(lines.back()["state"], "found") << lines.back();
}

TEST_F(Follow, CarriedAwayItHasNoPoseUntilItIsFound) { expectRightPosesThough(true); }

TEST_F(Follow, CarriedAwayBehindTheBackOfItsOdometryItHasNoPoseUntilItIsFound) {
  expectRightPosesThough(false);
}

/// Check fix for: a robot that was carried away, unseen by its odometry, before it was found got a
/// pose 226 m off where the other frames of the window had been.
TEST_F(Follow, CarriedAwayBeforeItWasFoundItHasNoPoseOfWhereItHadBeen) {
  const auto truth = truthOf("lidar_reverse");
  constexpr std::size_t kWindow = 16;
  const auto lastOf = [&](bool is_carried) {
    std::string text;
    for (std::size_t i = 0; i < kWindow; ++i) {
      const bool is_elsewhere = is_carried && i + 1 == kWindow;
      text += scan(is_elsewhere ? "lidar_elsewhere" : "lidar_reverse", i) + " " +
              poseLine(100 + static_cast<double>(i), truth[i].T_frame_sensor) + "\n";
    }
    const Outcome outcome = followLines(text, fmt::format("--window {0} --stride {0}", kWindow));
    return jsonLines(outcome.out).back();
  };
  EXPECT_EQ(lastOf(false)["state"], "found");
  const Json carried = lastOf(true);
  EXPECT_TRUE(carried["pose"].is_null()) << carried;
  EXPECT_NE(carried["reason"].get<std::string>().find("the scans contradict the odometry"),
            std::string::npos)
      << carried;
}

TEST_F(Follow, BadLinesAreAnsweredAndTheRestGoesOn) {
  const std::string identity = " 0 0 0 0 0 0 0 1\n";
  const Outcome outcome =
      followLines("nothing\n" + file("missing.pcd") + identity + scan("lidar_reverse", 0) +
                      " 0 nan 0 0 0 0 0 1\n" + scan("lidar_reverse", 0) + " 0 0 0 0 0 0 0 9\n" +
                      scan("lidar_reverse", 0) + identity,
                  "");
  EXPECT_EQ(outcome.code, 1);
  const std::vector<Json> lines = jsonLines(outcome.out);
  ASSERT_EQ(lines.size(), 5u) << outcome.out;
  for (std::size_t i = 0; i < 4; ++i) EXPECT_FALSE(lines[i].value("error", "").empty()) << lines[i];
  EXPECT_FALSE(lines[4].contains("error")) << lines[4];
}

TEST_F(Follow, AFolderThatFillsIsReadUntilItIsStopped) {
  const auto truth = truthOf("lidar_reverse");
  const std::string folder = file("filling");
  fs::create_directories(folder);
  std::thread robot([&] {
    std::string poses;
    for (std::size_t i = 0; i < 8; ++i) {
      fs::copy_file(scan("lidar_reverse", i), folder + fmt::format("/{:06}.bin", i));
      poses += poseLine(static_cast<double>(i), truth[i].T_frame_sensor) + "\n";
      // Half of the next line is there as well, as of a writer that is at work.
      writeText(folder + "/poses.txt", poses + "9 1 2");
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    writeText(folder + "/stop", "");
  });
  const Outcome outcome =
      runXview({"follow", "-q", folder, map(), "--stop", folder + "/stop"}, {50, 0, ""});
  robot.join();
  EXPECT_TRUE(outcome.code == 0 || outcome.code == 3) << outcome.code << outcome.err;
  const std::vector<Json> lines = jsonLines(outcome.out);
  ASSERT_EQ(lines.size(), 8u) << outcome.out;
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(lines[i]["stamp"], i);
    EXPECT_FALSE(lines[i].contains("error")) << lines[i];
  }
}

/// Scans of a drive in a folder that is watched until nothing comes any more.
class WatchedFolder : public Follow {
 protected:
  WatchedFolder() {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    fs::remove(file("pose.yaml"));
  }
  std::string path(std::size_t i) const { return folder_ + fmt::format("/{:06}.bin", i); }
  void put(std::size_t i) const { fs::copy_file(scan("lidar_reverse", i), path(i)); }
  std::string linesOfPoses(std::size_t count) const {
    const auto truth = truthOf("lidar_reverse");
    std::string lines;
    for (std::size_t i = 0; i < count; ++i)
      lines += poseLine(static_cast<double>(i), truth[i].T_frame_sensor) + "\n";
    return lines;
  }
  void writePoses(const std::string& text) const { writeText(folder_ + "/poses.txt", text); }
  Outcome watch(const char* idle_s = "0.5") const {
    return runXview({"follow", "-q", folder_, map(), "--idle", idle_s}, {50, 0, ""});
  }
  /// Every scan has one line; that of these has an error with these words, and no other one has.
  void expectErrors(std::size_t scans, const std::map<std::size_t, std::string>& words) const {
    const Outcome outcome = watch();
    EXPECT_EQ(outcome.code, 1);
    const std::vector<Json> lines = jsonLines(outcome.out);
    ASSERT_EQ(lines.size(), scans) << outcome.out;
    std::map<std::string, Json> line_of;
    for (const Json& line : lines) line_of[line["input"].get<std::string>()] = line;
    for (std::size_t i = 0; i < scans; ++i) {
      ASSERT_EQ(line_of.count(path(i)), 1u) << i;
      const std::string error = line_of[path(i)].value("error", "");
      const auto expected = words.find(i);
      if (expected == words.end())
        EXPECT_EQ(error, "");
      else
        EXPECT_NE(error.find(expected->second), std::string::npos) << error;
    }
  }

  const std::string folder_ = file("watched");
};

TEST_F(WatchedFolder, ABadNameCostsOneLine) {
  put(0);
  writeText(path(1), "");
  fs::create_symlink("/nowhere", path(2));
  fs::create_symlink("/dev/zero", path(3));
  ASSERT_EQ(mkfifo(path(4).c_str(), 0600), 0);
  fs::create_directory(path(5));
  writeText(path(6), std::string(1001, 'x'));
  put(7);
  expectErrors(8, {{1, "is empty"},
                   {2, "is a link to nothing"},
                   {3, "is not a regular file"},
                   {4, "is not a regular file"},
                   {5, "is a folder"},
                   {6, "16 bytes"}});
}

TEST_F(WatchedFolder, PoseLinesAreThoseOfTheNumberInTheName) {
  for (const std::size_t i : {0u, 2u, 3u}) put(i);
  writePoses("# a comment\n\n" + linesOfPoses(4));
  const std::vector<Json> lines = jsonLines(watch().out);
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[0]["stamp"], 0);
  EXPECT_EQ(lines[1]["stamp"], 2);
  EXPECT_EQ(lines[2]["stamp"], 3);
}

TEST_F(WatchedFolder, ABadLineOfPosesCostsOneLine) {
  for (std::size_t i = 0; i < 7; ++i) put(i);
  const std::string good = linesOfPoses(1);
  writePoses(good + "garbage\n1 nan 0 0 0 0 0 1\n1 1e9 0 0 0 0 0 1\n" + std::string(100000, 'x') +
             "\n" + good + "6 1 2");
  const std::string wrong = ": expected stamp tx ty tz";
  expectErrors(7, {{1, "line of frame 1" + wrong},
                   {2, "line of frame 2" + wrong},
                   {3, "line of frame 3" + wrong},
                   {4, "line of frame 4" + wrong},
                   {6, "no line of number 6"}});
}

TEST_F(WatchedFolder, PosesThatAreNoFileDoNotHang) {
  put(0);
  ASSERT_EQ(mkfifo((folder_ + "/poses.txt").c_str(), 0600), 0);
  expectErrors(1, {{0, "poses.txt: is not a regular file"}});
}

TEST_F(WatchedFolder, HalfAFileIsNotTaken) {
  const std::string whole = readText(scan("lidar_reverse", 0));
  std::thread robot([&] {
    std::ofstream writer(path(0), std::ios::binary);
    writer << whole.substr(0, whole.size() / 32 * 16) << std::flush;
    std::this_thread::sleep_for(std::chrono::milliseconds(150));
    writer << whole.substr(whole.size() / 32 * 16) << std::flush;
  });
  const std::vector<Json> halves = jsonLines(watch().out);
  robot.join();
  ASSERT_EQ(halves.size(), 1u);
  fs::remove(path(0));
  writeText(path(0), whole);
  const std::vector<Json> at_once = jsonLines(watch().out);
  ASSERT_EQ(at_once.size(), 1u);
  EXPECT_EQ(halves[0]["reason"], at_once[0]["reason"]) << "the same points were read";
}

/// A header tells that a file pauses, however long that is.
TEST_F(WatchedFolder, WhatIsShorterThanItsHeaderSaysIsWaitedFor) {
  LabelledCloud cloud;
  for (int i = 0; i < 1000; ++i)
    cloud.points.push_back(Point(static_cast<float>(i % 31), static_cast<float>(i % 17), 0, 1));
  io::writePcd(file("whole.pcd"), cloud);
  const std::string whole = readText(file("whole.pcd"));
  std::thread robot([&] {
    std::ofstream writer(folder_ + "/0.pcd", std::ios::binary);
    writer << whole.substr(0, whole.size() / 2) << std::flush;
    std::this_thread::sleep_for(std::chrono::milliseconds(600));
    writer << whole.substr(whole.size() / 2) << std::flush;
  });
  const Outcome outcome = watch("1.5");
  robot.join();
  const std::vector<Json> lines = jsonLines(outcome.out);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_FALSE(lines[0].contains("error")) << lines[0];
}

TEST_F(WatchedFolder, ThePoseFileOfAnEarlierRunIsRemovedFirst) {
  const auto isRemoved = [&](const std::vector<std::string>& arguments, int code) {
    writeText(file("pose.yaml"), "of an earlier run");
    std::vector<std::string> all = arguments;
    all.insert(all.end(), {"--initialpose", file("pose.yaml")});
    const Outcome outcome = runXview(all, {50, 0, ""});
    EXPECT_EQ(outcome.code, code) << outcome.err;
    EXPECT_NE(outcome.err.find("of an earlier query is removed until"), std::string::npos)
        << outcome.err;
    EXPECT_FALSE(fs::exists(file("pose.yaml")));
  };
  isRemoved({"follow", folder_, map(), "--idle", "0.1"}, 3);
  isRemoved({"follow", folder_, file("no.xvm"), "--idle", "0.1"}, 1);
  writeText(path(0), "no scan");
  isRemoved({"follow", folder_, map(), "--idle", "0.1"}, 1);
  isRemoved({"localize", path(0), file("no.xvm")}, 1);
}

TEST_F(Follow, AWrongPoseIsSaidAndALongLineIsRefusedInLittleMemory) {
  const std::string given = scan("lidar_reverse", 0);
  for (const char* pose : {"1 nan 0 0 0 0 0 1", "1 2 3", "1 1e9 0 0 0 0 0 1"}) {
    const std::vector<Json> lines = jsonLines(followLines(given + " " + pose + "\n", "").out);
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_EQ(lines[0]["input"], given);
    EXPECT_NE(lines[0]["error"].get<std::string>().find(
                  fmt::format("its pose: expected stamp tx ty tz qx qy qz qw: finite numbers, "
                              "within 1e8 m, with a quaternion of length 1, found '{}'",
                              pose)),
              std::string::npos)
        << lines[0];
  }
  const Outcome outcome =
      runProgram("/bin/sh",
                 {"-c", fmt::format("(head -c 400000000 /dev/zero | tr '\\0' a; echo; echo {}) | "
                                    "'{}' follow -q - '{}'",
                                    given, XVIEW_PROGRAM, map())},
                 {60, 300, ""});
  const std::vector<Json> lines = jsonLines(outcome.out);
  ASSERT_EQ(lines.size(), 2u) << outcome.out.substr(0, 300) << outcome.err.substr(0, 300);
  EXPECT_NE(lines[0]["error"].get<std::string>().find("a line of more than 8192 bytes"),
            std::string::npos);
  EXPECT_FALSE(lines[1].contains("error"));
}

}  // namespace
}  // namespace xview::test
