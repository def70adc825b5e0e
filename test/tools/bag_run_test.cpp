// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "io/small_files.h"
#include "support/bags.h"
#include "tools/tiny_town.h"
#include "xview/base/frame.h"
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
  const Outcome wrong = runXview({"info", file("drive.mcap"), "--topic", "/pionts"});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_NE(wrong.err.find("/points"), std::string::npos) << wrong.err;
}

}  // namespace
}  // namespace xview::test
