// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>

#include <filesystem>
#include <limits>

#include "recording_folder.h"
#include "support/clouds.h"
#include "support/test_data.h"
#include "xview/base/error.h"
#include "xview/io/cloud_files.h"

namespace xview::io {
namespace {

namespace fs = std::filesystem;

/// Two scans of two points in the layout of SemanticKITTI.
class KittiFolder : public test::RecordingFolder {
 protected:
  KittiFolder() {
    for (const int number : {3, 4}) {
      const std::string stem = "00000" + std::to_string(number);
      write("velodyne/" + stem + ".bin", test::scanBytes({1, 2, 3, 0, 4, 5, 6, 0}));
      writeLabels(stem, {40, 80 | 5u << 16});
    }
    // z of the camera is x of the velodyne.
    write("calib.txt", "P0: 1 0 0 0 0 1 0 0 0 0 1 0\nTr: 0 -1 0 0 0 0 -1 0 1 0 0 0.5\n");
    write("poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 2\n");
  }
  void writeLabels(const std::string& stem, const std::vector<std::uint32_t>& labels) const {
    write("labels/" + stem + ".label", test::labelBytes(labels));
  }
  std::string labelSetOf(const std::vector<std::uint32_t>& labels) const {
    writeLabels("000003", labels);
    writeLabels("000004", labels);
    return openRecording(folder_.path())->labels().name();
  }
};

TEST_F(KittiFolder, GivesScansInTheFrameOfTheVelodyne) {
  EXPECT_EQ(recogniseInput(folder_.path()), InputKind::semantic_kitti);
  const auto source = openRecording(folder_.path());
  ASSERT_EQ(source->size(), 2u);
  EXPECT_EQ(source->sensor(), Sensor::lidar);
  EXPECT_EQ(source->labels().name(), "semantic_kitti");
  EXPECT_TRUE(source->pose(0).isApprox(Eigen::Isometry3d::Identity()));
  EXPECT_TRUE(source->pose(1).translation().isApprox(Eigen::Vector3d(2, 0, 0)));
  const Frame frame = source->read(1);
  EXPECT_EQ(frame.number, 4);
  ASSERT_EQ(frame.cloud.size(), 2u);
  EXPECT_EQ(frame.cloud.points[1].label, 80u);
  EXPECT_EQ(test::instancesOf(frame.cloud), (std::vector<std::uint32_t>{0, 5}));
  EXPECT_EQ(frame.cloud.position(1), Eigen::Vector3d(4, 5, 6));
}

TEST_F(KittiFolder, WithoutCalibrationPosesAreThoseOfTheScanner) {
  fs::remove(folder_ / "calib.txt");
  const auto source = openRecording(folder_.path());
  EXPECT_TRUE(source->pose(1).translation().isApprox(Eigen::Vector3d(0, 0, 2)));
  ASSERT_FALSE(source->notes().empty());
  EXPECT_EQ(source->notes()[0],
            "no calib.txt: poses.txt is taken as poses of the scanner, not of a camera");
}

TEST(RecordedScans, OfRellisOpenWithoutCalibration) {
  XVIEW_REQUIRE_DATA(data, "rellis3d/map");
  if (!fs::exists(data)) GTEST_SKIP() << data << " is not here";
  const auto source = openRecording(data);
  EXPECT_EQ(source->sensor(), Sensor::lidar);
  EXPECT_NE(source->notes()[0].find("no calib.txt"), std::string::npos);
  EXPECT_TRUE(source->pose(0).isApprox(Eigen::Isometry3d::Identity()));
  const LabelledCloud scan = source->read(0).cloud;
  EXPECT_GT(scan.size(), 70000u);
  EXPECT_GT(scan.left_out.repeated, 50000u) << "pulses that do not come back are zeros";
}

TEST_F(KittiFolder, TakesStampsFromTimesIfThereAreAny) {
  EXPECT_EQ(openRecording(folder_.path())->stamp(1), 1);
  write("times.txt", "0.5\n0.75\n");
  EXPECT_EQ(openRecording(folder_.path())->stamp(1), 0.75);
  write("times.txt", "0\n0.1\n0.2\n0.3\n0.4\n");
  EXPECT_EQ(openRecording(folder_.path())->stamp(1), 0.4);
  write("times.txt", "0\n");
  EXPECT_EQ(openMessage(folder_.path()), folder_.path() + "/times.txt: 1 times for 2 frames");
}

TEST_F(KittiFolder, TellsTheThreeIdSpacesApart) {
  EXPECT_EQ(labelSetOf({40, 10}), "semantic_kitti");
  EXPECT_EQ(labelSetOf({40, 252}), "semantic_kitti");
  EXPECT_EQ(labelSetOf({9, 19}), "semantic_kitti_train_1");
  EXPECT_EQ(labelSetOf({8, 255}), "semantic_kitti_train_0");
  EXPECT_EQ(labelSetOf({9, 15}), "semantic_kitti_train_1");
  EXPECT_EQ(labelSetOf({8, 14}), "semantic_kitti_train_0");
  EXPECT_EQ(labelSetOf({100, 200}), "generic");
  write("classes.yaml", "name: mine\nclasses: [{id: 0, name: road}]\n");
  EXPECT_EQ(labelSetOf({40, 10}), "mine");
}

TEST_F(KittiFolder, NeedsPosesUnlessThereIsOneScan) {
  fs::remove(folder_ / "poses.txt");
  EXPECT_NE(openMessage(folder_.path()).find("poses.txt: cannot open"), std::string::npos);
  fs::remove(folder_ / "velodyne/000004.bin");
  fs::remove(folder_ / "labels/000004.label");
  EXPECT_TRUE(openRecording(folder_.path())->pose(0).isApprox(Eigen::Isometry3d::Identity()));
}

TEST_F(KittiFolder, ThatIsDamagedSaysWhatAndWhere) {
  const std::string root = folder_.path();
  fs::remove(folder_ / "labels/000004.label");
  EXPECT_EQ(openMessage(root),
            root + ": 2 .bin files but 1 .label files; 000004 has no .label file");
  writeLabels("000004", {40, 40});
  write("calib.txt", "Tr: 1 2 3\n");
  EXPECT_EQ(openMessage(root), root + "/calib.txt:1: Tr: expected 12 numbers, found 3");
  write("calib.txt", "P0: 1\n");
  EXPECT_NE(openMessage(root).find(root + "/calib.txt: no line `Tr: `"), std::string::npos);
}

TEST_F(KittiFolder, OneScanIsFoundWithItsLabels) {
  const std::string scan = folder_ / "velodyne/000004.bin";
  EXPECT_EQ(recogniseInput(scan), InputKind::semantic_kitti);
  const auto source = openRecording(scan);
  ASSERT_EQ(source->size(), 1u);
  EXPECT_EQ(source->number(0), 4);
  EXPECT_EQ(source->read(0).cloud.size(), 2u);
  const std::string loose = write("loose/a.bin", test::scanBytes({1, 2, 3, 0}));
  EXPECT_TRUE(openRecording(loose)->labels().empty()) << "raw";
  EXPECT_EQ(openRecording(loose)->read(0).cloud.points[0].label, 0u);
  write("loose/a.label", test::labelBytes({40}));
  EXPECT_EQ(openRecording(loose)->read(0).cloud.points[0].label, 40u);
}

// ---- single scans

using test::raw;

class KittiScan : public ::testing::Test {
 protected:
  void write(const std::string& scan, const std::string& labels) const {
    test::writeText(scan_, scan);
    test::writeText(labels_, labels);
  }
  std::string error() const {
    return test::messageOf<Error>([&] { readKittiScan(scan_, labels_); });
  }

  test::TemporaryFolder folder_;
  const std::string scan_ = folder_ / "000000.bin";
  const std::string labels_ = folder_ / "000000.label";
};

std::string point(float x, float y, float z) { return raw(x) + raw(y) + raw(z) + raw(0.5f); }

TEST_F(KittiScan, ClassIsInTheLowAndInstanceInTheHighBits) {
  write(point(1, 2, 3) + point(-4, 5, -6), raw(0x00070050u) + raw(0xFFFF00FFu));
  const LabelledCloud cloud = readKittiScan(scan_, labels_);
  ASSERT_EQ(cloud.size(), 2u);
  EXPECT_EQ(cloud.position(0), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(cloud.position(1), Eigen::Vector3d(-4, 5, -6));
  EXPECT_EQ(cloud.points[0].label, 0x50u);
  EXPECT_EQ(cloud.points[1].label, 0xFFu);
  EXPECT_EQ(test::instancesOf(cloud), (std::vector<std::uint32_t>{7, 0xFFFF}));
}

TEST_F(KittiScan, PointsThatAreNotFiniteGoWithTheirLabels) {
  write(point(std::numeric_limits<float>::quiet_NaN(), 2, 3) + point(4, 5, 6), raw(10u) + raw(20u));
  const LabelledCloud cloud = readKittiScan(scan_, labels_);
  ASSERT_EQ(cloud.size(), 1u);
  EXPECT_EQ(cloud.points[0].label, 20u);
}

TEST_F(KittiScan, EmptyIsAnEmptyCloud) {
  write("", "");
  EXPECT_TRUE(readKittiScan(scan_, labels_).empty());
}

TEST_F(KittiScan, SizesThatDisagreeAreErrorsWithBothNumbers) {
  write(point(1, 2, 3) + point(4, 5, 6), raw(10u));
  EXPECT_EQ(error(), labels_ + ": expected 2 labels of 4 bytes, one for each point of " + scan_ +
                         ", found 4 bytes");
  write(point(1, 2, 3) + "abc", raw(10u));
  EXPECT_EQ(error(), scan_ +
                         ": expected 16 bytes per point (x y z intensity), found 19 bytes: 3 are "
                         "left after 1 points");
}

/// Check fix for: scans of nuScenes became noise where their size is that of rows of four.
TEST_F(KittiScan, RowsOfFiveNumbersAreTold) {
  std::string rows, labels;
  for (int i = 0; i < 8; ++i) {
    rows += point(0.5F * static_cast<float>(i), -1, 2) + raw(static_cast<float>(i * 4 % 32));
    labels += raw(static_cast<std::uint32_t>(i));
  }
  write(rows, labels);
  const LabelledCloud cloud = readKittiScan(scan_, labels_);
  ASSERT_EQ(cloud.size(), 8u);
  EXPECT_EQ(cloud.points[6].getVector3fMap(), Eigen::Vector3f(3, -1, 2));
  EXPECT_EQ(cloud.points[6].label, 6u);
  const auto source = openRecording(scan_);
  const std::vector<std::string> notes = source->notes();
  EXPECT_TRUE(std::any_of(notes.begin(), notes.end(), [](const std::string& note) {
    return note.find("five numbers") != std::string::npos;
  }));
}

TEST_F(KittiScan, AMissingLabelFileIsNamed) {
  test::writeText(scan_, point(1, 2, 3));
  EXPECT_EQ(error(), labels_ + ": cannot open: No such file or directory");
}

TEST(RecordedKittiScan, HasItsClasses) {
  XVIEW_REQUIRE_DATA(data, "kitti00/query_4501");
  const LabelledCloud cloud =
      readKittiScan(data + "/velodyne/004501.bin", data + "/labels/004501.label");
  EXPECT_GT(cloud.size(), 50000u);
  for (const Point& point : cloud.points) ASSERT_LE(point.label, 259u);
}

}  // namespace
}  // namespace xview::io
