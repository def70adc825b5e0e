// SPDX-License-Identifier: BSD-3-Clause
#include "io/bag_files.h"

#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/stat.h>

#include <cstring>
#include <filesystem>

#include "base/pose.h"
#include "base/random.h"
#include "small_files.h"
#include "support/bags.h"
#include "support/test_data.h"
#include "xview/base/error.h"

namespace xview::io {
namespace {

namespace fs = std::filesystem;
using test::BagMessage;
using test::LogShape;
using test::raw;
using test::Wire;

std::int64_t ns(double seconds) { return std::llround(1e9 * seconds); }

/// Where the odometry says that the robot is.
Eigen::Isometry3d bodyAt(double stamp_s) {
  return poseFromYaw({stamp_s - 100, 2 * (stamp_s - 100), 0.5}, 0.3 * (stamp_s - 100));
}

const Eigen::Isometry3d kT_base_lidar = poseFromYaw({0.2, 0, 1.5}, M_PI / 2);

std::vector<Eigen::Vector4f> pointsOf(int frame) {
  std::vector<Eigen::Vector4f> points;
  for (int i = 0; i < 50; ++i)
    points.emplace_back(0.1F * i, static_cast<float>(frame), -1.25F, static_cast<float>(i % 3));
  return points;
}

constexpr int kClouds = 7;
double stampOf(int frame) { return 100.05 + 0.1 * frame; }

/// Clouds between the poses of an odometry, and how the scanner is mounted.
std::vector<BagMessage> drive(Wire wire) {
  std::vector<BagMessage> messages;
  messages.push_back({"/tf_static", "tf2_msgs/TFMessage", ns(99),
                      test::transformsMessage(wire, {{0, "/base", "lidar", kT_base_lidar}})});
  for (int i = 0; i <= kClouds; ++i) {
    const double stamp_s = 100 + 0.1 * i;
    messages.push_back({"/odom", "nav_msgs/Odometry", ns(stamp_s),
                        test::odometryMessage(wire, stamp_s, "odom", "base", bodyAt(stamp_s))});
    messages.push_back({"/imu", "sensor_msgs/Imu", ns(stamp_s), std::string(300, 'i')});
    if (i == kClouds) break;
    messages.push_back({"/points", "sensor_msgs/PointCloud2", ns(stampOf(i) + 0.02),
                        test::labelledCloudMessage(wire, stampOf(i), "lidar", pointsOf(i))});
  }
  return messages;
}

void expectDrive(const FrameSource& source, std::size_t frames = kClouds) {
  ASSERT_EQ(source.size(), frames);
  EXPECT_EQ(source.sensor(), Sensor::lidar);
  for (std::size_t i = 0; i < frames; ++i) {
    const double stamp_s = stampOf(static_cast<int>(i));
    EXPECT_NEAR(source.stamp(i), stamp_s, 1e-6);
    const Eigen::Isometry3d expected = bodyAt(stamp_s) * kT_base_lidar;
    EXPECT_TRUE(source.pose(i).isApprox(expected, 1e-6)) << i << '\n' << source.pose(i).matrix();
    const Frame frame = source.read(i);
    const auto points = pointsOf(static_cast<int>(i));
    ASSERT_EQ(frame.cloud.size(), points.size());
    for (std::size_t k = 0; k < points.size(); ++k) {
      EXPECT_EQ(frame.cloud.points[k].getVector3fMap(), points[k].head<3>());
      EXPECT_EQ(frame.cloud.points[k].label, static_cast<std::uint32_t>(points[k][3]));
    }
  }
}

class Bags : public ::testing::Test {
 protected:
  std::string write(const std::string& name, const std::vector<BagMessage>& messages,
                    const LogShape& shape = {}) const {
    const std::string path = folder_ / name;
    test::writeBag(path, messages, shape);
    return path;
  }
  test::TemporaryFolder folder_;
};

TEST_F(Bags, McapGivesWhatWasWrittenForEveryCompressionAndByteOrder) {
  for (const Wire wire : {Wire::cdr_little, Wire::cdr_big}) {
    for (const char* compression : {"", "zstd", "lz4"}) {
      for (const bool has_indices : {true, false}) {
        for (const bool is_closed : {true, false}) {
          LogShape shape;
          shape.compression = compression;
          shape.has_indices = has_indices;
          shape.is_closed = is_closed;
          SCOPED_TRACE(std::string(compression) + (has_indices ? " indexed" : "") +
                       (is_closed ? " closed" : ""));
          const auto source = openRecording(write("a.mcap", drive(wire), shape));
          expectDrive(*source);
        }
      }
    }
  }
  LogShape plain;
  plain.has_chunks = false;
  expectDrive(*openRecording(write("a.mcap", drive(Wire::cdr_little), plain)));
  LogShape ros1;
  ros1.encoding = "ros1";
  expectDrive(*openRecording(write("a.mcap", drive(Wire::ros1), ros1)));
}

TEST_F(Bags, Ros1BagsGiveWhatWasWrittenForEveryCompression) {
  for (const char* compression : {"", "bz2", "lz4"}) {
    for (const bool is_closed : {true, false}) {
      SCOPED_TRACE(std::string(compression) + (is_closed ? " closed" : ""));
      LogShape shape;
      shape.compression = compression;
      shape.is_closed = is_closed;
      expectDrive(*openRecording(write("a.bag", drive(Wire::ros1), shape)));
    }
  }
}

TEST_F(Bags, DatabasesAndFoldersOfRosbag2GiveWhatWasWritten) {
  const auto messages = drive(Wire::cdr_little);
  expectDrive(*openRecording(write("a.db3", messages)));
  EXPECT_FALSE(fs::exists(folder_ / "a.db3-wal"));
  const std::string folder = folder_ / "drive";
  test::writeText(folder + "/metadata.yaml", "rosbag2_bagfile_information: {}\n");
  const auto middle = messages.begin() + 10;
  for (const char* ending : {".db3", ".mcap"}) {
    test::writeBag(folder + "/drive_0" + ending, {messages.begin(), middle});
    test::writeBag(folder + "/drive_1" + ending, {middle, messages.end()});
    EXPECT_EQ(recogniseInput(folder), InputKind::bag);
    expectDrive(*openRecording(folder));
    test::writeText(folder + "/drive_2" + ending, "");
    ASSERT_EQ(openRecording(folder)->notes().size(), 1u);
    EXPECT_EQ(openRecording(folder)->notes()[0].rfind("is read without ", 0), 0u);
    fs::remove(folder + "/drive_2" + ending);
    fs::remove(folder + "/drive_0" + ending);
    fs::remove(folder + "/drive_1" + ending);
  }
}

TEST_F(Bags, MessagesMayBeCompressedOneByOne) {
  auto messages = drive(Wire::cdr_little);
  for (BagMessage& message : messages) message.bytes = test::packed("zstd", message.bytes);
  expectDrive(*openRecording(write("a.db3", messages)));
}

TEST_F(Bags, WhatNeverChangesInTransformsMountsTheSensor) {
  auto messages = drive(Wire::ros1);
  messages.erase(messages.begin());
  for (int i = 0; i < 4; ++i)
    messages.push_back(
        {"/tf", "tf2_msgs/TFMessage", ns(100 + i),
         test::transformsMessage(
             Wire::ros1, {{100.0 + i, "base", "mast", poseFromYaw({0, 0, 1}, 0)},
                          {100.0 + i, "mast", "lidar", poseFromYaw({0, 0, -1}, 0) * kT_base_lidar},
                          {100.0 + i, "odom", "base", bodyAt(100 + i)}})});
  expectDrive(*openRecording(write("a.bag", messages)));
}

TEST_F(Bags, TopicsAreListedWithWhatIsTaken) {
  auto messages = drive(Wire::cdr_little);
  messages.push_back({"/few", "sensor_msgs/PointCloud2", ns(100),
                      test::labelledCloudMessage(Wire::cdr_little, 100, "lidar", pointsOf(0))});
  const std::string path = write("a.mcap", messages);
  const auto topics = bagTopics(path);
  ASSERT_EQ(topics.size(), 5u);
  EXPECT_EQ(topics[0].name, "/few");
  EXPECT_EQ(topics[1].name, "/imu");
  EXPECT_EQ(topics[1].messages, 8u);
  EXPECT_NEAR(topics[1].duration_s, 0.7, 1e-6);
  EXPECT_EQ(topics[1].taken_as, "");
  EXPECT_EQ(topics[2].taken_as, "poses");
  EXPECT_EQ(topics[3].taken_as, "clouds");
  EXPECT_EQ(topics[3].type, "sensor_msgs/PointCloud2");
  InputOptions options;
  options.topic = "few";
  EXPECT_EQ(openRecording(path, options)->size(), 1u);
  options.topic = "/pionts";
  EXPECT_NE(test::messageOf<UsageError>([&] { openRecording(path, options); }).find("is /points"),
            std::string::npos);
  options.topic = "/odom";
  EXPECT_NE(test::messageOf<UsageError>([&] {
              openRecording(path, options);
            }).find("no topic with clouds or depth images"),
            std::string::npos);
  options = {};
  options.odometry = "/points";
  EXPECT_NE(test::messageOf<UsageError>([&] {
              openRecording(path, options);
            }).find("poses or transforms"),
            std::string::npos);
}

std::vector<BagMessage> without(const std::string& topic, std::vector<BagMessage> messages) {
  messages.erase(std::remove_if(messages.begin(), messages.end(),
                                [&](const BagMessage& m) { return m.topic == topic; }),
                 messages.end());
  return messages;
}

TEST_F(Bags, TransformsAndPosesServeWhereThereIsNoOdometry) {
  for (const Wire wire : {Wire::ros1, Wire::cdr_little, Wire::cdr_big}) {
    const std::string name = wire == Wire::ros1 ? "a.bag" : "a.mcap";
    auto transforms = without("/odom", drive(wire)), poses = without("/tf_static", transforms);
    for (int i = 0; i <= kClouds; ++i) {
      const double stamp_s = 100 + 0.1 * i;
      transforms.push_back(
          {"/tf", "tf2_msgs/TFMessage", ns(stamp_s),
           test::transformsMessage(wire, {{stamp_s, "base", "wheel", bodyAt(-stamp_s)},
                                          {stamp_s, "map", "odom", bodyAt(7 * stamp_s)},
                                          {stamp_s, "odom", "base", bodyAt(stamp_s)}})});
      test::MessageWriter pose(wire);
      pose.header(stamp_s, "odom").pose(bodyAt(stamp_s) * kT_base_lidar);
      poses.push_back({"/pose", "geometry_msgs/PoseStamped", ns(stamp_s), pose.bytes()});
    }
    const std::string of_transforms = write(name, transforms);
    expectDrive(*openRecording(of_transforms));
    ASSERT_TRUE(mountingIn(of_transforms, {}));
    EXPECT_TRUE(mountingIn(of_transforms, {})->isApprox(kT_base_lidar, 1e-9));
    const std::string of_poses = write(name, poses);
    EXPECT_FALSE(mountingIn(of_poses, {})) << "no transform says it";
    const auto source = openRecording(of_poses);
    ASSERT_EQ(source->size(), static_cast<std::size_t>(kClouds));
    EXPECT_LT(
        (source->pose(3).translation() - (bodyAt(stampOf(3)) * kT_base_lidar).translation()).norm(),
        1e-3);
    ASSERT_EQ(source->notes().size(), 1u);
    EXPECT_NE(source->notes()[0].find("no static transform from 'lidar'"), std::string::npos);
  }
}

TEST_F(Bags, SayWhereTheScannerIsOnTheRobot) {
  const auto T_base_sensor = mountingIn(write("a.mcap", drive(Wire::cdr_little)), {});
  ASSERT_TRUE(T_base_sensor);
  EXPECT_TRUE(T_base_sensor->isApprox(kT_base_lidar, 1e-9));
}

TEST_F(Bags, FramesWithoutPosesAreLeftOutAndSaid) {
  auto messages = drive(Wire::cdr_little);
  for (const double stamp_s : {99.5, 101.0})
    messages.push_back({"/points", "sensor_msgs/PointCloud2", ns(stamp_s),
                        test::labelledCloudMessage(Wire::cdr_little, stamp_s, "lidar", {})});
  const auto source = openRecording(write("a.mcap", messages));
  EXPECT_EQ(source->size(), static_cast<std::size_t>(kClouds));
  EXPECT_EQ(source->number(0), 1);
  ASSERT_EQ(source->notes().size(), 1u);
  EXPECT_EQ(source->notes()[0].rfind("2 of 9 messages of /points are left out", 0), 0u);
  const auto alone = without("/odom", drive(Wire::cdr_little));
  const std::string path = write("b.mcap", alone);
  EXPECT_NE(test::messageOf<Error>([&] { openRecording(path); }).find("--frames 0:1"),
            std::string::npos);
  InputOptions one;
  one.frames = parseFrameRange("2:3");
  const auto frame = openRecording(path, one);
  ASSERT_EQ(frame->size(), 1u);
  EXPECT_NEAR(frame->stamp(0), stampOf(2), 1e-6);
  EXPECT_TRUE(frame->pose(0).isApprox(Eigen::Isometry3d::Identity()));
}

TEST_F(Bags, StampsOfZeroAreThoseOfTheRecorder) {
  std::vector<BagMessage> messages;
  for (int i = 0; i < 4; ++i) {
    const std::int64_t log_ns = ns(100 + i);
    messages.push_back({"/o", "nav_msgs/Odometry", log_ns,
                        test::odometryMessage(Wire::ros1, 0, "odom", "lidar", bodyAt(100 + i))});
    messages.push_back({"/p", "sensor_msgs/PointCloud2", log_ns,
                        test::labelledCloudMessage(Wire::ros1, 0, "lidar", pointsOf(i))});
  }
  const auto source = openRecording(write("a.bag", messages));
  ASSERT_EQ(source->size(), 4u);
  EXPECT_NEAR(source->stamp(2), 102, 1e-6);
  ASSERT_EQ(source->notes().size(), 1u);
  EXPECT_EQ(source->notes()[0].rfind("8 messages have no stamp", 0), 0u);
}

/// Check fix for: a scanner that counts from when it was switched on met no pose.
TEST_F(Bags, StampsOfAnotherClockAreThoseOfTheRecorder) {
  std::vector<BagMessage> messages;
  for (int i = 0; i < 4; ++i) {
    messages.push_back(
        {"/o", "nav_msgs/Odometry", ns(100 + i),
         test::odometryMessage(Wire::cdr_little, 1.7e9 + i, "odom", "lidar", bodyAt(100 + i))});
    messages.push_back(
        {"/p", "sensor_msgs/PointCloud2", ns(100 + i),
         test::labelledCloudMessage(Wire::cdr_little, 3484 + i, "lidar", pointsOf(i))});
  }
  const auto source = openRecording(write("a.mcap", messages));
  ASSERT_EQ(source->size(), 4u);
  EXPECT_TRUE(source->pose(2).isApprox(bodyAt(102), 1e-6));
  ASSERT_EQ(source->notes().size(), 1u);
  EXPECT_NE(source->notes()[0].find("(3484.000 to 3487.000 s) are of another clock than those of "
                                    "/o (1700000000.000 to 1700000003.000 s)"),
            std::string::npos)
      << source->notes()[0];
}

/// Check fix for: of a robot that lost its power nothing was read.
TEST_F(Bags, PartsWithoutMetadataAreReadInTheOrderOfTheirNumbers) {
  fs::create_directory(folder_ / "parts");
  const auto messages = drive(Wire::cdr_little);
  const std::size_t third = messages.size() / 3;
  const std::string names[] = {"parts/d_2.mcap", "parts/d_9.mcap", "parts/d_10.mcap"};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto begin = messages.begin() + static_cast<std::ptrdiff_t>(i * third);
    write(names[i], {begin, i == 2 ? messages.end() : begin + static_cast<std::ptrdiff_t>(third)});
  }
  const auto source = openRecording(folder_ / "parts");
  expectDrive(*source);
  EXPECT_NE(source->notes().at(0).find("no metadata.yaml"), std::string::npos);
  const std::string metadata = folder_ / "parts/metadata.yaml",
                    list =
                        "rosbag2_bagfile_information:\n  relative_file_paths:\n    - d_2.mcap\n    "
                        "- d_9.mcap.zstd\n"
                        "    - d_10.mcap\n";
  test::writeText(metadata, list + "    - d_11.mcap\n    - d_12.mcap.zstd\n");
  test::writeText(folder_ / "parts/d_12.mcap.zstd", "packed");
  const auto notes = openRecording(folder_ / "parts")->notes();
  ASSERT_EQ(notes.size(), 2u);
  EXPECT_EQ(notes[0],
            "is read without 'd_11.mcap', which metadata.yaml lists and which is not there");
  EXPECT_EQ(notes[1].rfind("is read without 'd_12.mcap.zstd', which is compressed; ", 0), 0u);
  test::writeText(metadata, list);
  EXPECT_TRUE(openRecording(folder_ / "parts")->notes().empty());
  for (const char* part : {"d_2.mcap", "d_9.mcap", "d_10.mcap"})
    fs::rename(fs::path(folder_ / "parts") / part, folder_ / part);
  EXPECT_NE(test::messageOf<Error>([&] {
              openRecording(folder_ / "parts");
            }).find("parts are compressed; unpack them: unzstd "),
            std::string::npos);
  for (const char* part : {"d_2.mcap", "d_9.mcap", "d_10.mcap"})
    fs::rename(folder_ / part, fs::path(folder_ / "parts") / part);
  fs::remove(metadata);
  write("parts/another_0.mcap", messages);
  EXPECT_FALSE(isBag(folder_ / "parts")) << "two recordings are not one";
  fs::create_directory(folder_ / "days");
  write("days/20261130.mcap", messages);
  EXPECT_FALSE(isBag(folder_ / "days"));
}

TEST_F(Bags, CloudsInTheFrameOfTheOdometryAreTakenBackToTheSensor) {
  std::vector<BagMessage> messages;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Isometry3d T = bodyAt(100 + i);
    std::vector<Eigen::Vector4f> points;
    for (const Eigen::Vector4f& p : pointsOf(i)) {
      points.push_back(p);
      points.back().head<3>() = (T * p.head<3>().cast<double>()).cast<float>();
    }
    messages.push_back({"/o", "nav_msgs/Odometry", ns(100 + i),
                        test::odometryMessage(Wire::ros1, 100 + i, "camera_init", "body", T)});
    messages.push_back({"/cloud_registered", "sensor_msgs/PointCloud2", ns(100 + i),
                        test::labelledCloudMessage(Wire::ros1, 100 + i, "camera_init", points)});
  }
  const auto source = openRecording(write("a.bag", messages));
  ASSERT_EQ(source->size(), 3u);
  const Frame frame = source->read(2);
  EXPECT_TRUE(frame.T_odom_sensor.isApprox(bodyAt(102), 1e-9));
  EXPECT_LT((frame.cloud.position(9) - pointsOf(2)[9].head<3>().cast<double>()).norm(), 1e-5);
  InputOptions moved;
  moved.moved = Eigen::Affine3d(Eigen::Translation3d(100, 20, 3));
  const Frame there = openRecording(folder_ / "a.bag", moved)->read(2);
  EXPECT_LT(
      (there.T_odom_sensor.translation() - bodyAt(102).translation() - Eigen::Vector3d(100, 20, 3))
          .norm(),
      1e-9);
  EXPECT_LT((there.cloud.position(9) - frame.cloud.position(9)).norm(), 1e-5)
      << "in the frame of the sensor";
}

TEST_F(Bags, LivoxCloudsAreRead) {
  const std::vector<Eigen::Vector3f> points = {{1, 2, 3}, {4, 5, 6}, {-7, 8.5F, 9}};
  for (const Wire wire : {Wire::ros1, Wire::cdr_little, Wire::cdr_big}) {
    const std::string type =
        wire == Wire::ros1 ? "livox_ros_driver/CustomMsg" : "livox_ros_driver2/CustomMsg";
    const auto source =
        openRecording(write(wire == Wire::ros1 ? "a.bag" : "a.db3",
                            {{"/livox", type, ns(1), test::livoxMessage(wire, 1, "l", points)}}));
    EXPECT_TRUE(source->labels().empty());
    const LabelledCloud cloud = source->read(0).cloud;
    ASSERT_EQ(cloud.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(cloud.points[i].getVector3fMap(), points[i]);
  }
}

TEST_F(Bags, CloudsMayBeOrganisedPaddedDoubleOrBigEndian) {
  test::CloudLayout layout{{{"x", 4, 8}, {"y", 12, 8}, {"z", 20, 8}, {"ring", 1, 4}}, 32};
  layout.width = 2;
  layout.height = 3;
  layout.line_bytes = 80;
  layout.big_endian = true;
  std::string data(240, '\7');
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::string bytes = raw(static_cast<double>(10 * i + axis));
      std::reverse(bytes.begin(), bytes.end());
      data.replace(80 * (i / 2) + 32 * (i % 2) + 4 + 8 * axis, 8, bytes);
    }
  }
  const auto messageWith = [&](const test::CloudLayout& as) {
    return std::vector<BagMessage>{{"/p", "sensor_msgs/PointCloud2", ns(1),
                                    test::cloudMessage(Wire::cdr_little, 1, "l", as, data)}};
  };
  const LabelledCloud cloud = openRecording(write("a.mcap", messageWith(layout)))->read(0).cloud;
  ASSERT_EQ(cloud.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_EQ(cloud.position(i), Eigen::Vector3d(10.0 * i, 10.0 * i + 1, 10.0 * i + 2));
  const auto refusal = [&](test::CloudLayout lying, auto change) {
    change(lying);
    const std::string path = write("b.mcap", messageWith(lying));
    return test::messageOf<Error>([&] { openRecording(path)->read(0); });
  };
  using Layout = test::CloudLayout;
  const std::pair<std::string, const char*> cases[] = {
      {refusal(layout, [](Layout& as) { as.width = 4000000000; }), "points of 32 bytes in 240"},
      {refusal(layout, [](Layout& as) { as.height = as.width = 4294967295; }), "in 240 bytes"},
      {refusal(layout, [](Layout& as) { as.line_bytes = 4000000000; }), "in 240 bytes"},
      {refusal(layout, [](Layout& as) { as.point_bytes = 27; }), "their fields take 28"},
      {refusal(layout, [](Layout& as) { as.fields[2].offset = 4294967295; }), "fields take"},
      {refusal(layout, [](Layout& as) { as.fields[2].name = "q"; }), "has no field z"},
      {refusal(layout, [](Layout& as) { as.fields[2].type = 9; }), "has no field z"}};
  for (const auto& [message, expected] : cases) {
    EXPECT_NE(message.find(expected), std::string::npos) << expected << ": " << message;
    EXPECT_NE(message.find("b.mcap: "), std::string::npos) << message;
    EXPECT_NE(message.find("in the message of /p"), std::string::npos) << message;
  }
}

TEST_F(Bags, DepthImagesAreReadWithTheirCameraInfo) {
  for (const Wire wire : {Wire::ros1, Wire::cdr_little, Wire::cdr_big}) {
    const std::string name = wire == Wire::ros1 ? "a.bag" : "a.mcap";
    std::vector<BagMessage> messages = {{"/rgb/camera_info", "sensor_msgs/CameraInfo", 0,
                                         test::cameraInfoMessage(wire, "c", 9, 9, 9)},
                                        {"/depth/camera_info", "sensor_msgs/CameraInfo", 0,
                                         test::cameraInfoMessage(wire, "c", 3, 2, 50)}};
    const auto image = [&](double stamp_s, const std::string& encoding, std::uint32_t step,
                           const std::string& data) {
      test::MessageWriter writer(wire);
      writer.header(stamp_s, "c").number(std::uint32_t{2}).number(std::uint32_t{3});
      writer.text(encoding).number(std::uint8_t{0}).number(step);
      writer.number(static_cast<std::uint32_t>(data.size())).raw(data);
      messages.push_back({"/depth/image", "sensor_msgs/Image", ns(stamp_s), writer.bytes()});
      messages.push_back({"/o", "nav_msgs/Odometry", ns(stamp_s),
                          test::odometryMessage(wire, stamp_s, "odom", "c", bodyAt(stamp_s))});
    };
    std::string millimetres, metres;
    for (int i = 0; i < 6; ++i) {
      millimetres += raw(static_cast<std::uint16_t>(1000 * i));
      metres += raw(i == 5 ? std::numeric_limits<float>::quiet_NaN() : 1.5F * i);
      if (i % 3 == 2) millimetres += "pp";
    }
    image(1, "16UC1", 8, millimetres);
    image(2, "32FC1", 12, metres);
    const auto source = openRecording(write(name, messages));
    ASSERT_EQ(source->size(), 2u);
    EXPECT_EQ(source->sensor(), Sensor::camera);
    const Frame first = source->read(0), second = source->read(1);
    EXPECT_EQ(first.camera.width, 3);
    EXPECT_EQ(first.camera.fx, 50);
    EXPECT_EQ(first.camera.cy, 1);
    EXPECT_EQ(first.depth.pixels, (std::vector<float>{0, 1, 2, 3, 4, 5}));
    EXPECT_EQ(second.depth.pixels, (std::vector<float>{0, 1.5F, 3, 4.5F, 6, 0}));
    EXPECT_EQ(bagTopics(folder_ / name)[1].taken_as, "depth");
    EXPECT_EQ(bagTopics(folder_ / name)[0].taken_as, "camera");
  }
}

TEST_F(Bags, ImagesMayBePartsOfWhatTheSensorSees) {
  const auto cameraOf = [&](const std::string& info) {
    test::MessageWriter writer(Wire::cdr_little);
    writer.header(1, "c").number(std::uint32_t{2}).number(std::uint32_t{3});
    writer.text("16UC1").number(std::uint8_t{0}).number(std::uint32_t{6});
    writer.number(std::uint32_t{12}).raw(std::string(12, 'd'));
    return openRecording(
               write("a.mcap", {{"/d/camera_info", "sensor_msgs/CameraInfo", 0, info},
                                {"/d/image", "sensor_msgs/Image", ns(1), writer.bytes()}}))
        ->read(0)
        .camera;
  };
  const Wire wire = Wire::cdr_little;
  const Camera binned = cameraOf(test::cameraInfoMessage(wire, "c", 6, 4, 50, {2, 0, 0, 0, 0}));
  EXPECT_EQ(binned.fx, 25);
  EXPECT_EQ(binned.cx, 1.25) << "the middle of pixel 0 of two is 0.5";
  const Camera region = cameraOf(test::cameraInfoMessage(wire, "c", 9, 9, 50, {1, 4, 5, 3, 2}));
  EXPECT_EQ(region.fx, 50);
  EXPECT_EQ(region.cx, 0.5);
  EXPECT_EQ(region.cy, -0.5);
  EXPECT_EQ(region.height, 2);
  for (const auto& [info, why] :
       {std::pair(test::cameraInfoMessage(wire, "c", 9, 9, 50, {1, 7, 5, 3, 2}), "region"),
        std::pair(test::cameraInfoMessage(wire, "c", 3, 2, 50, {}, "equidistant", 0.1),
                  "rectify them")})
    EXPECT_NE(test::messageOf<Error>([&] { cameraOf(info); }).find(why), std::string::npos);
}

TEST_F(Bags, DepthPackedByRvlIsRead) {
  // 0 0 150 148 0 300 in numbers of four bits: 2 zeros, 2 others (+150, -2), 1 zero, 1 other
  // (+152). Folded, 150 is 300 = 454 in eights from below: 4, 5, 4; 152 is 304 = 0, 6, 4; -2 is 3.
  const std::vector<std::uint32_t> nibbles{2, 2, 4 | 8, 5 | 8, 4, 3, 1, 1, 0 | 8, 6 | 8, 4};
  std::vector<std::uint32_t> words(2, 0);
  for (std::size_t i = 0; i < nibbles.size(); ++i) words[i / 8] |= nibbles[i] << (28 - 4 * (i % 8));
  const auto depthOf = [&](std::size_t bytes) {
    const std::string packed = raw(words[0]) + raw(words[1]);
    const std::string data = raw(std::int32_t{0}) + raw(0.0F) + raw(0.0F) + raw(std::int32_t{3}) +
                             raw(std::int32_t{2}) + packed.substr(0, bytes);
    test::MessageWriter writer(Wire::cdr_little);
    writer.header(1, "c").text("16UC1; compressedDepth rvl");
    writer.number(static_cast<std::uint32_t>(data.size())).raw(data);
    return openRecording(
               write("a.mcap", {{"/d/camera_info", "sensor_msgs/CameraInfo", 0,
                                 test::cameraInfoMessage(Wire::cdr_little, "c", 3, 2, 50)},
                                {"/d/image/compressedDepth", "sensor_msgs/CompressedImage", ns(1),
                                 writer.bytes()}}))
        ->read(0)
        .depth.pixels;
  };
  EXPECT_EQ(depthOf(8), (std::vector<float>{0, 0, 0.15F, 0.148F, 0, 0.3F}));
  EXPECT_NE(test::messageOf<Error>([&] { depthOf(4); }).find("ends at byte 4"), std::string::npos);
}

TEST_F(Bags, CompressedDepthIsRead) {
  const auto wire = Wire::cdr_little;
  for (const bool is_float : {false, true}) {
    std::vector<BagMessage> messages = {{"/d/camera_info", "sensor_msgs/CameraInfo", 0,
                                         test::cameraInfoMessage(wire, "c", 2, 1, 50)}};
    test::MessageWriter writer(wire);
    const std::string data =
        raw(std::int32_t{0}) + raw(100.0F) + raw(-50.0F) + test::pngBytes(2, 1, 1, 16, {0, 150});
    writer.header(1, "c").text(is_float ? "32FC1; compressedDepth png" : "16UC1; compressedDepth");
    writer.number(static_cast<std::uint32_t>(data.size())).raw(data);
    messages.push_back(
        {"/d/image/compressedDepth", "sensor_msgs/CompressedImage", ns(1), writer.bytes()});
    const Frame frame = openRecording(write("a.mcap", messages))->read(0);
    EXPECT_EQ(frame.depth.pixels, (std::vector<float>{0, is_float ? 0.5F : 0.15F}));
  }
}

// ---- what is wrong with files

TEST_F(Bags, ATruncatedOneIsReadUpToTheBreak) {
  for (const char* name : {"a.mcap", "a.bag", "a.db3"}) {
    const Wire wire = std::string(name) == "a.bag" ? Wire::ros1 : Wire::cdr_little;
    const std::string whole = test::readText(write(name, drive(wire)));
    std::size_t read = 0;
    for (std::size_t tenths = 1; tenths < 10; ++tenths) {
      const std::string path = folder_ / name;
      test::writeText(path, whole.substr(0, whole.size() * tenths / 10));
      try {
        const auto source = openRecording(path);
        bool is_said = false;
        for (const std::string& note : source->notes())
          is_said |= note.find("breaks off") != std::string::npos;
        EXPECT_TRUE(is_said) << name << tenths;
        for (std::size_t i = 0; i < source->size(); ++i) source->read(i);
        read = std::max(read, source->size());
      } catch (const Error& problem) {
        EXPECT_EQ(std::string(problem.what()).find('\n'), std::string::npos);
      }
    }
    EXPECT_GT(read, 2u) << name;
  }
}

TEST_F(Bags, LyingSizesAreRefusedInOneLine) {
  const std::string path = folder_ / "a.mcap";
  LogShape zstd;
  zstd.compression = "zstd";
  const std::string good = test::mcapBytes(drive(Wire::cdr_little), zstd);
  const std::size_t chunk = good.find('\6', 8 + 9);
  const auto messageWith = [&](std::size_t at, const std::string& bytes) {
    std::string bad = good;
    test::writeText(path, bad.replace(at, bytes.size(), bytes));
    return test::messageOf<Error>([&] {
      const auto source = openRecording(path);
      for (std::size_t i = 0; i < source->size(); ++i) source->read(i);
    });
  };
  const std::size_t unpacked_bytes = chunk + 9 + 16;
  const std::pair<std::string, const char*> cases[] = {
      {messageWith(unpacked_bytes, raw(std::uint64_t{1} << 40)),
       "unpack to more than 34031532 bytes"},
      {messageWith(unpacked_bytes, raw(std::uint64_t{1} << 24)), "expected 16777216"},
      {messageWith(unpacked_bytes, raw(std::uint64_t{100})), "bytes and more, expected 100"},
      {messageWith(unpacked_bytes + 16, "zzzz"), "expected chunks of zstd"},
      {messageWith(chunk + 1, raw(std::uint64_t{1} << 60)),
       "a record of 1152921504606846976 bytes"},
      {messageWith(0, "X"), "expected a log"}};
  for (const auto& [message, expected] : cases) {
    EXPECT_NE(message.find(expected), std::string::npos) << expected << ": " << message;
    EXPECT_NE(message.find("a.mcap: "), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

/// Where the records of one kind begin in an MCAP.
std::vector<std::size_t> recordsOf(const std::string& mcap, char kind) {
  std::vector<std::size_t> records;
  for (std::size_t at = 8; at + 9 <= mcap.size();) {
    if (mcap[at] == kind) records.push_back(at);
    std::uint64_t length = 0;
    std::memcpy(&length, &mcap[at + 1], 8);
    at += 9 + length;
  }
  return records;
}

TEST_F(Bags, AnIndexThatLiesIsRefused) {
  const std::string path = folder_ / "a.mcap";
  for (const char* compression : {"", "zstd"}) {
    LogShape shape;
    shape.compression = compression;
    shape.chunk_messages = 10;
    const std::string good = test::mcapBytes(drive(Wire::cdr_little), shape);
    constexpr std::size_t kId = 9, kEntries = 15;
    const auto index = recordsOf(good, '\7');
    std::string other = good, twice = good;
    for (const std::size_t at : index) {
      if (other[at + kId] == 2) other[at + kId] = 3;  // what is of /imu is said to be of /points
    }
    test::writeText(path, other);
    EXPECT_NE(test::messageOf<Error>([&] {
                openRecording(path);
              }).find("says a message of channel 3, found one of channel 2"),
              std::string::npos);
    twice.replace(index[1] + kEntries + 16, 16, twice, index[1] + kEntries, 16);
    test::writeText(path, twice);
    EXPECT_NE(test::messageOf<Error>([&] { openRecording(path); }).find("twice"),
              std::string::npos);
  }
}

TEST_F(Bags, WhatUnpacksToMuchMoreThanItsFileIsRefused) {
  const std::string zeros(std::size_t{20} << 20, '\0');
  LogShape shape;
  shape.chunk_messages = 1;
  shape.compression = "zstd";
  const std::vector<BagMessage> messages = {{"/p", "sensor_msgs/PointCloud2", 1, zeros},
                                            {"/p", "sensor_msgs/PointCloud2", 2, zeros}};
  std::string path = write("a.mcap", messages, shape);
  EXPECT_NE(test::messageOf<Error>([&] { openRecording(path); }).find("its first 2 chunks say"),
            std::string::npos);
  path =
      write("a.db3", {{"/p", "sensor_msgs/PointCloud2", 1, test::packed("zstd", zeros + zeros)}});
  const std::string message = test::messageOf<Error>([&] { openRecording(path); });
  EXPECT_NE(message.find("a chunk of 41943040 bytes, expected"), std::string::npos) << message;
}

TEST_F(Bags, HeadsOfPackedMessagesAreUnpackedAsFarAsTheyAreRead) {
  auto messages = drive(Wire::cdr_little);
  for (BagMessage& message : messages) {
    if (message.type != "nav_msgs/Odometry") continue;
    // The end of a long message is damaged; only its beginning is read.
    std::string bytes = message.bytes;
    Random random(3);
    for (int i = 0; i < 500000; ++i) bytes += static_cast<char>(random.below(256));
    message.bytes = test::packed("zstd", bytes);
    message.bytes.resize(message.bytes.size() - 1000);
  }
  expectDrive(*openRecording(write("a.db3", messages)));
}

TEST_F(Bags, MoreConnectionsThanAnyRobotHasAreRefused) {
  const std::string one = test::rosBagBytes({{"/a", "std_msgs/String", 1, "a"}}, {});
  std::string bag = one.substr(0, 13);  // without its first record, which says where a summary is
  const auto field = [](const std::string& text) {
    return raw(static_cast<std::uint32_t>(text.size())) + text;
  };
  const std::string description = field("topic=/a") + field("type=std_msgs/String");
  for (std::uint32_t i = 0; i <= 65536; ++i)
    bag += field(field("op=\7") + field("conn=" + raw(i)) + field("topic=/a")) + field(description);
  const std::string path = folder_ / "a.bag";
  test::writeText(path, bag);
  EXPECT_NE(test::messageOf<Error>([&] { bagTopics(path); }).find("more than 65536 connections"),
            std::string::npos);
}

/// Runs SQL on a database, its schema written as rows if need be.
void execute(const std::string& path, const std::string& sql) {
  sqlite3* database = nullptr;
  sqlite3_open(path.c_str(), &database);
  char* problem = nullptr;
  EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, &problem), SQLITE_OK) << problem;
  sqlite3_close(database);
}

TEST_F(Bags, NothingThatADatabaseDefinesIsRun) {
  const std::string endless =
      "AS WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x FROM c) SELECT x AS id, 1 AS "
      "topic_id, 1 AS timestamp, 'a' AS data, 'x' AS name, 'x' AS type, 'cdr' AS "
      "serialization_format FROM c";
  const auto asRow = [](const std::string& type, const std::string& name, const std::string& sql) {
    std::string quoted;
    for (const char c : sql) quoted += c == '\'' ? std::string("''") : std::string(1, c);
    return "PRAGMA writable_schema = ON; INSERT INTO sqlite_master(rowid, type, name, tbl_name, "
           "rootpage, sql) VALUES(-5, '" +
           type + "', '" + name + "', '" + name + "', 0, '" + quoted + "')";
  };
  const std::string topics =
      "INSERT INTO topics(id, type, serialization_format) VALUES(1, 'x', "
      "'cdr')";
  const std::pair<std::string, const char*> cases[] = {
      {"DROP TABLE messages; CREATE VIEW messages " + endless, "found 'messages'"},
      {asRow("view", "MESSAGES", "CREATE VIEW MESSAGES " + endless), "found 'MESSAGES'"},
      {asRow("table", "TOPICS", "CREATE VIEW TOPICS " + endless), "found 'TOPICS'"},
      {asRow("table", "x", "create view messages " + endless), "found 'x'"},
      {asRow("table", "Messages", "CREATE TABLE Messages(a)"), "several times the table messages"},
      {asRow("table", "MESSAGES", "CREATE VIRTUAL TABLE MESSAGES USING generate_series"),
       "found 'MESSAGES'"},
      {"CREATE TRIGGER t AFTER INSERT ON topics BEGIN SELECT 1; END", "found 't'"},
      {"DROP TABLE topics; CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT AS "
       "(zeroblob(900000000)), type TEXT, serialization_format TEXT); " +
           topics,
       "the computed column 'name' of the table topics"},
      {"DROP TABLE topics; CREATE TABLE Topics(id INTEGER PRIMARY KEY, name TEXT AS (upper(type)) "
       "STORED, type TEXT, serialization_format TEXT); " +
           topics,
       "the computed column 'name' of the table topics"},
      {"DROP TABLE topics", "none with the table topics"}};
  for (const auto& [sql, expected] : cases) {
    const std::string path = write("a.db3", drive(Wire::cdr_little));
    execute(path, sql);
    const std::string message = test::messageOf<Error>([&] { openRecording(path); });
    EXPECT_NE(message.find(expected), std::string::npos) << sql << ": " << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    fs::remove(path);
  }
}

TEST_F(Bags, OtherTablesAndIndicesOfADatabaseAreLeftAlone) {
  const std::string path = write("a.db3", drive(Wire::cdr_little));
  execute(path,
          "CREATE UNIQUE INDEX names ON topics(name); CREATE TABLE schema("
          "schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL); CREATE TABLE metadata("
          "id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL)");
  expectDrive(*openRecording(path));
}

std::string bigEndian(std::uint32_t value, int bytes) {
  std::string text;
  for (int i = bytes - 1; i >= 0; --i) text += static_cast<char>(value >> (8 * i) & 0xFF);
  return text;
}

/// Each page of a tree names the next one 30 times: a scan of 10 kB would end after 30^9 rows.
TEST_F(Bags, ADatabaseWhosePagesLieUponOneAnotherIsRefused) {
  const std::string path = folder_ / "a.db3";
  execute(path,
          "PRAGMA page_size = 512; CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type "
          "TEXT, serialization_format TEXT); CREATE TABLE messages(id INTEGER PRIMARY KEY, "
          "topic_id INTEGER, timestamp INTEGER, data BLOB); INSERT INTO messages VALUES(1, 1, 1, "
          "'a')");
  std::string file = test::readText(path);
  const std::size_t root = file.size() - 512;  // of `messages`, the last that was made
  const auto first = static_cast<std::uint32_t>(file.size() / 512) + 1;
  const auto pageOver = [](std::uint32_t child) {
    constexpr int kCells = 30;
    std::string page = "\5" + bigEndian(0, 2) + bigEndian(kCells, 2) +
                       bigEndian(512 - 5 * kCells, 2) + bigEndian(0, 1) + bigEndian(child, 4);
    for (int i = 0; i < kCells; ++i) page += bigEndian(512 - 5 * (kCells - i), 2);
    page.resize(512 - 5 * kCells);
    for (int i = 0; i < kCells; ++i) page += bigEndian(child, 4) + '\1';
    return page;
  };
  const std::string leaf = file.substr(root);
  file.replace(root, 512, pageOver(first));
  for (std::uint32_t i = 0; i < 8; ++i) file += pageOver(first + i + 1);
  file += leaf;
  file.replace(28, 4, bigEndian(static_cast<std::uint32_t>(file.size() / 512), 4));
  test::writeText(path, file);
  EXPECT_NE(test::messageOf<Error>([&] { openRecording(path); }).find("takes more steps"),
            std::string::npos);
}

TEST_F(Bags, AWriteAheadLogIsReadAndNothingIsWritten) {
  const auto messages = drive(Wire::cdr_little);
  const std::string path = write("a.db3", {messages.begin(), messages.begin() + 5}),
                    killed = folder_ / "killed/a.db3", whole = folder_ / "whole.db3";
  test::writeDatabase(whole, messages);
  sqlite3* database = nullptr;
  sqlite3_open(path.c_str(), &database);
  sqlite3_exec(database,
               ("PRAGMA journal_mode = WAL; ATTACH '" + whole +
                "' AS whole; INSERT OR IGNORE INTO topics SELECT * FROM whole.topics; INSERT OR "
                "IGNORE INTO messages SELECT * FROM whole.messages")
                   .c_str(),
               nullptr, nullptr, nullptr);
  fs::create_directories(folder_ / "killed");
  for (const bool has_index : {false, true}) {
    for (const char* ending : {"", "-wal", "-shm"}) {
      if (has_index || std::string(ending) != "-shm")
        fs::copy_file(path + ending, killed + ending, fs::copy_options::overwrite_existing);
    }
    const std::string file = test::readText(killed), log = test::readText(killed + "-wal");
    expectDrive(*openRecording(killed));
    EXPECT_EQ(test::readText(killed), file);
    EXPECT_EQ(test::readText(killed + "-wal"), log);
    EXPECT_EQ(fs::exists(killed + "-shm"), has_index);
  }
  fs::remove(killed + "-shm");
  ASSERT_EQ(mkfifo((killed + "-shm").c_str(), 0600), 0);  // which is not waited for
  expectDrive(*openRecording(killed));
  expectDrive(*openRecording(path));  // while it is being recorded
  sqlite3_close(database);
}

/// The journal of a database is not looked at, whatever it says.
TEST_F(Bags, AJournalBesideADatabaseIsLeftAlone) {
  const std::string path = write("a.db3", drive(Wire::cdr_little));
  test::writeText(path + "-journal",
                  std::string("\xD9\xD5\x05\xF9\x20\xA1\x63\xD7", 8) + std::string(504, '\1'));
  expectDrive(*openRecording(path));
  EXPECT_TRUE(fs::exists(path + "-journal"));
}

TEST_F(Bags, DamagedOnesEndInFramesOrAnError) {
  for (const char* name : {"a.mcap", "b.mcap", "a.bag", "b.bag", "a.db3"}) {
    LogShape shape;
    if (name[0] == 'b') shape.compression = "lz4";
    const bool is_ros1 = std::string(name).find(".bag") != std::string::npos;
    const std::string good =
        test::readText(write(name, drive(is_ros1 ? Wire::ros1 : Wire::cdr_little), shape));
    for (std::uint64_t i = 0; i < 300; ++i) {
      Random random(11, i);
      std::string bytes = good;
      for (std::uint32_t flips = 1 + random.below(6); flips > 0; --flips)
        bytes[random.below(static_cast<std::uint32_t>(bytes.size()))] ^=
            static_cast<char>(1 << random.below(8));
      test::writeText(folder_ / name, bytes);
      try {
        bagTopics(folder_ / name);
        const auto source = openRecording(folder_ / name);
        for (std::size_t k = 0; k < source->size(); ++k) source->read(k);
      } catch (const Error& problem) {
        EXPECT_EQ(std::string(problem.what()).find('\n'), std::string::npos) << problem.what();
        EXPECT_NE(std::string(problem.what()).find(name), std::string::npos) << problem.what();
      }
    }
  }
}

}  // namespace
}  // namespace xview::io
