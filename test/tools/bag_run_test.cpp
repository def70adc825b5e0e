// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>

#include "base/random.h"
#include "io/small_files.h"
#include "support/bags.h"
#include "support/test_data.h"
#include "tools/tiny_town.h"
#include "xview/base/frame.h"
#include "xview/io/cloud_files.h"
#include "xview/io/recording.h"

namespace xview::test {
namespace {

/// A simulated drive of a scanner as the messages of a robot.
std::vector<BagMessage> messagesOf(const FrameSource& drive, Wire wire) {
  std::vector<BagMessage> messages;
  for (std::size_t i = 0; i < drive.size(); ++i) {
    const double stamp_s = drive.stamp(i) + 1000;
    const auto log_ns = static_cast<std::int64_t>(1e9 * stamp_s);
    CloudLayout layout{
        {{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}, {"label", 12, 6}, {"instance", 16, 6}}, 20};
    std::string data;
    for (const Point& point : drive.read(i).cloud.points) {
      data += raw(point.x) + raw(point.y) + raw(point.z) + raw(point.label) + raw(point.instance);
      ++layout.width;
    }
    messages.push_back({"/odometry", "nav_msgs/Odometry", log_ns,
                        odometryMessage(wire, stamp_s, "odom", "lidar", drive.pose(i))});
    messages.push_back({"/points", "sensor_msgs/PointCloud2", log_ns,
                        cloudMessage(wire, stamp_s, "lidar", layout, data)});
  }
  return messages;
}

TEST_F(TinyTown, ADriveInABagIsFoundWhereItsFolderIs) {
  const std::string classes = town("lidar_reverse") + "/classes.yaml", scans = file("of_scans.xvm");
  succeed({"map", "-q", town("lidar"), scans});
  const auto localize = [&](const std::string& query) {
    const Json answer =
        Json::parse(succeed({"localize", "-q", "--json", "--labels", classes, query, scans}).out);
    EXPECT_EQ(answer["status"], "accepted") << query << ": " << answer["reason"];
    return poseIn(answer);
  };
  const Eigen::Isometry3d expected = localize(town("lidar_reverse"));
  const auto drive = io::openRecording(town("lidar_reverse"));
  for (const char* name : {"drive.mcap", "drive.db3", "drive.bag"}) {
    const Wire wire = std::string(name) == "drive.bag" ? Wire::ros1 : Wire::cdr_little;
    LogShape shape;
    shape.compression = "lz4";
    writeBag(file(name), messagesOf(*drive, wire), shape);
    const Eigen::Isometry3d found = localize(file(name));
    EXPECT_TRUE(found.isApprox(expected, 1e-9)) << name << '\n'
                                                << (expected.inverse() * found).matrix();
    const Outcome info = succeed({"info", "--json", file(name)});
    EXPECT_EQ(Json::parse(info.out)["topics"][1]["taken_as"], "clouds") << info.out;
    EXPECT_EQ(Json::parse(info.out)["frames"]["count"], drive->size());
  }
  // The odometry is that of the scanner itself, whose pose is that of the base then.
  const std::string pose = file("pose.yaml");
  succeed(
      {"localize", "-q", "--labels", classes, file("drive.mcap"), scans, "--initialpose", pose});
  EXPECT_EQ(readText(pose).rfind("# pose of the base of the robot\n", 0), 0u);
  auto scans_only = messagesOf(*drive, Wire::cdr_little);
  scans_only.erase(std::remove_if(scans_only.begin(), scans_only.end(),
                                  [](const BagMessage& m) { return m.topic == "/odometry"; }),
                   scans_only.end());
  writeBag(file("scans.mcap"), scans_only, {});
  const Outcome followed =
      runXview({"follow", "-q", "--labels", classes, "--frames", "2:5", file("scans.mcap"), scans});
  ASSERT_EQ(std::count(followed.out.begin(), followed.out.end(), '\n'), 3) << followed.err;
  const Json last = Json::parse(followed.out.substr(followed.out.rfind("{\"frame\"")));
  EXPECT_EQ(last["frame"], 4);
  EXPECT_NEAR(last["stamp"], drive->stamp(4) + 1000, 1e-6);
  const Outcome wrong = runXview({"info", file("drive.mcap"), "--topic", "/pionts"});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_NE(wrong.err.find("/points"), std::string::npos) << wrong.err;
}

TEST_F(TinyTown, AQueryThatIsLargerThanTheMapMayBeSwapped) {
  const std::string large = file("large.pcd"), small = file("small.pcd");
  succeed({"lift", "-q", town("lidar"), large});
  LabelledCloud yard;  // of another place
  Random random(5);
  for (int i = 0; i < 4000; ++i) {
    const auto x = static_cast<float>(random.uniform(0, 15)),
               y = static_cast<float>(random.uniform(0, 15));
    yard.points.emplace_back(x, y, i % 3 > 0 ? 0 : static_cast<float>(random.uniform(0, 4)), 0);
  }
  io::writePcd(small, yard, nullptr);
  const Outcome swapped = runXview({"localize", large, small, "--labels", "shapes"});
  EXPECT_EQ(swapped.code, 3) << swapped.out;
  EXPECT_NE(swapped.err.find("are QUERY and MAP swapped?"), std::string::npos) << swapped.err;
}

}  // namespace
}  // namespace xview::test
