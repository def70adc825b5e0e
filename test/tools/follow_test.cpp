// SPDX-License-Identifier: BSD-3-Clause
// xview follow: frames of a recording, of standard input, of a folder that fills.
#include <gtest/gtest.h>

#include <fmt/core.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <thread>

#include "tools/tiny_town.h"
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
  EXPECT_NE(carried["reason"].get<std::string>().find("does not fit"), std::string::npos)
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

}  // namespace
}  // namespace xview::test
