// SPDX-License-Identifier: BSD-3-Clause
// Clouds that are given back moved, with all that their points have.
#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "io/point_table.h"
#include "small_files.h"
#include "support/e57.h"
#include "support/test_data.h"
#include "xview/base/error.h"
#include "xview/io/cloud_files.h"
#include "xview/io/recording.h"

namespace xview::io {
namespace {

using test::raw;

/// The rows of a cloud file, each with the values of its fields.
std::vector<std::vector<double>> rowsOf(const std::string& path) {
  InputFile file(path);
  const FileLayout layout = readCloudLayout(file);
  const Element& points = pointsIn(layout, file);
  std::vector<std::size_t> all(points.columns.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  std::vector<std::vector<double>> rows;
  readTable(file, layout, points, all, [&](const double* values, const RowPlace&) {
    rows.emplace_back(values, values + all.size());
    for (int i = 0; i < 3; ++i)
      rows.back()[static_cast<std::size_t>(i)] = values[i] * layout.scale[i] + layout.offset[i];
  });
  return rows;
}

class CloudCopies : public ::testing::Test {
 protected:
  CloudCopies() {
    moved_.linear() = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()).matrix();
    moved_.translation() << 100, 200, 3;
    std::string body;
    for (int i = 0; i < 3; ++i)
      body += raw(1.5F * i) + raw(-2.0F) + raw(0.25F) + raw(0xFF8040C0U) + raw(1.0F) + raw(0.0F) +
              raw(0.0F) + raw(0.5F * i) + raw(1700000000.125 + i) +
              raw(static_cast<std::uint16_t>(7 + i)) + raw(static_cast<std::uint8_t>(40 + i)) +
              raw(std::uint32_t{1}) + raw(std::uint32_t{2});
    body.replace(0, 4, raw(std::numeric_limits<float>::quiet_NaN()));
    test::writeText(pcd_,
                    "# xview label_set own\n# xview class 40 object pole 1 2 3 lamp\nVERSION .7\n"
                    "FIELDS x y z rgb normal_x normal_y normal_z intensity time ring label code\n"
                    "SIZE 4 4 4 4 4 4 4 4 8 2 1 4\nTYPE F F F F F F F F F U U U\n"
                    "COUNT 1 1 1 1 1 1 1 1 1 1 1 2\nWIDTH 3\nHEIGHT 1\nPOINTS 3\nDATA binary\n" +
                        body);
  }

  test::TemporaryFolder folder_;
  Eigen::Affine3d moved_ = Eigen::Affine3d::Identity();
  const std::string pcd_ = folder_ / "a.pcd";
};

TEST_F(CloudCopies, KeepTheFieldsOfEveryPoint) {
  const std::vector<std::string> fields{"x",        "y",        "z",        "rgb",
                                        "normal_x", "normal_y", "normal_z", "intensity",
                                        "time",     "ring",     "label"};
  for (const char* name : {"b.pcd", "b.ply"}) {
    const std::vector<std::string> notes = copyCloud(pcd_, folder_ / name, moved_);
    ASSERT_EQ(notes.size(), 1u);
    EXPECT_NE(notes[0].find("code"), std::string::npos) << notes[0];
    const CloudHeader header = readCloudHeader(folder_ / name);
    EXPECT_EQ(header.fields, fields);
    ASSERT_TRUE(header.labels);
    EXPECT_EQ(header.labels->className(40), "lamp");
    const auto rows = rowsOf(folder_ / name);
    ASSERT_EQ(rows.size(), 3u);
    EXPECT_TRUE(std::isnan(rows[0][0] + rows[0][1])) << "a point that was not measured stays";
    EXPECT_NEAR(rows[2][0], 102, 1e-5);
    EXPECT_NEAR(rows[2][1], 203, 1e-5);
    EXPECT_NEAR(rows[2][5], 1, 1e-6) << "normals turn along";
    EXPECT_EQ(rows[2][7], 1);
    EXPECT_EQ(rows[2][8], 1700000002.125);
    EXPECT_EQ(rows[2][9], 9);
    EXPECT_EQ(rows[2][10], 42);
    EXPECT_NE(test::readText(folder_ / name).find(raw(0xFF8040C0U)), std::string::npos)
        << "a colour whose float is no number";
  }
}

/// Check fix for: intensity and colours of an E57 were lost without a word.
TEST_F(CloudCopies, OfAnE57HaveTheFieldsOfAllItsScans) {
  test::E57Points scan;
  scan.columns = {
      test::e57Real("cartesianX", 64),     test::e57Real("cartesianY", 64),
      test::e57Real("cartesianZ", 64),     test::e57Whole("intensity", 0, 4095, "scale=\"0.25\""),
      test::e57Whole("colorRed", 0, 255),  test::e57Whole("colorGreen", 0, 255),
      test::e57Whole("colorBlue", 0, 255), test::e57Whole("rowIndex", 0, 70000)};
  scan.rows = {{1, 2, 3, 10, 11, 12, 13, 65536}};
  test::E57Points other = scan;
  other.columns.pop_back();
  other.rows = {{4, 5, 6, 20, 21, 22, 23}};
  const std::string e57 = folder_ / "a.e57";
  test::writeText(e57, test::e57Paged(test::e57Content({scan, other})));
  for (const char* name : {"a.pcd", "a.ply"}) {
    const std::vector<std::string> notes = copyCloud(e57, folder_ / name, moved_);
    ASSERT_EQ(notes.size(), 1u) << name;
    EXPECT_NE(notes[0].find("rowIndex"), std::string::npos) << notes[0];
    const std::vector<std::string> fields{"x", "y", "z", "intensity", "red", "green", "blue"};
    EXPECT_EQ(readCloudHeader(folder_ / name).fields, fields);
    const auto rows = rowsOf(folder_ / name);
    ASSERT_EQ(rows.size(), 2u);
    EXPECT_EQ(rows[0][3], 2.5);
    EXPECT_EQ(rows[1][6], 23);
  }
}

TEST_F(CloudCopies, OfAnE57HaveRoomForTheNumbersOfAllItsScans) {
  test::E57Points scan;
  scan.columns = {test::e57Real("cartesianX", 64), test::e57Real("cartesianY", 64),
                  test::e57Real("cartesianZ", 64), test::e57Whole("intensity", 0, 255),
                  test::e57Whole("colorRed", 0, 255)};
  scan.rows = {{1, 2, 3, 255, 7}};
  test::E57Points other = scan;
  other.columns.pop_back();
  other.columns.back() = test::e57Whole("intensity", -5, 60000);
  other.columns.push_back(test::e57Real("nor:normalX", 32));
  other.rows = {{4, 5, 6, 59000, 1}};
  const std::string e57 = folder_ / "b.e57";
  test::writeText(e57, test::e57Paged(test::e57Content({scan, other})));
  const std::vector<std::string> notes = copyCloud(e57, folder_ / "b.ply", moved_);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("colorRed"), std::string::npos) << notes[0];
  EXPECT_NE(notes[0].find("nor:normalX"), std::string::npos) << notes[0];
  const auto rows = rowsOf(folder_ / "b.ply");
  ASSERT_EQ(rows.size(), 2u);
  ASSERT_EQ(rows[0].size(), 4u);
  EXPECT_EQ(rows[0][3], 255);
  EXPECT_EQ(rows[1][3], 59000);
}

TEST_F(CloudCopies, InLasHaveClassIntensityTimeAndColour) {
  moved_.translation() << 4.0e5, 5.3e6, 100;
  const std::string las = folder_ / "b.las";
  const std::vector<std::string> notes = copyCloud(pcd_, las, moved_);
  ASSERT_EQ(notes.size(), 2u);
  EXPECT_NE(notes[1].find("no place for it: normal_x, normal_y, normal_z"), std::string::npos)
      << notes[1];
  const LabelledCloud cloud = readCloud(las);
  ASSERT_EQ(cloud.size(), 2u) << "what is not finite has no place in LAS";
  EXPECT_LT((cloud.position(1) - Eigen::Vector3d(400002, 5300003, 100.25)).norm(), 1e-3);
  EXPECT_EQ(cloud.points[1].label, 42u);
  EXPECT_EQ(readCloudHeader(las).labels->className(40), "lamp");
  const auto rows = rowsOf(las);
  // X Y Z intensity returns flags classification user_data scan_angle point_source gps_time r g b
  EXPECT_EQ(rows[1][3], 65535);
  EXPECT_EQ(rows[1][4], 0x11);
  EXPECT_EQ(rows[1][9], 9);
  EXPECT_EQ(rows[1][10], 1700000002.125);
  EXPECT_EQ(rows[1][11], 257 * 0x80);
  EXPECT_EQ(rows[1][13], 257 * 0xC0);
  copyCloud(las, folder_ / "c.ply", Eigen::Affine3d::Identity());
  EXPECT_LT((readCloud(folder_ / "c.ply").position(1) - cloud.position(1)).norm(), 1e-6)
      << "doubles far from the origin";
  EXPECT_EQ(openRecording(las)->labels().className(40), "lamp")
      << "they are not those of the ASPRS";
}

TEST_F(CloudCopies, HaveLengthsOfTheScaleThatTheyAreMovedBy) {
  test::writeText(folder_ / "s.ply",
                  "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
                  "property float z\nproperty float sigma\nproperty uint label\nend_header\n"
                  "1 2 3 0.5 4294967295\n");
  moved_ = Eigen::Affine3d(Eigen::Scaling(2.0));
  copyCloud(folder_ / "s.ply", folder_ / "t.ply", moved_);
  EXPECT_EQ(rowsOf(folder_ / "t.ply")[0], (std::vector<double>{2, 4, 6, 1, 4294967295.0}));
  copyCloud(folder_ / "s.ply", folder_ / "t.las", moved_);
  EXPECT_EQ(readCloud(folder_ / "t.las").points[0].label, 0u) << "-1 is none";
  moved_ = Eigen::Affine3d(Eigen::Scaling(1e-3));
  copyCloud(folder_ / "t.las", folder_ / "u.las", moved_);
  EXPECT_NEAR(rowsOf(folder_ / "u.las")[0][2], 0.006, 1e-9) << "not as coarse as before";
}

TEST_F(CloudCopies, OfLabelledCloudsAreReadFromLasAsTheyWere) {
  LabelledCloud cloud;
  cloud.origin << 4.0e5, 5.3e6, 100;
  for (int i = 0; i < 5; ++i) cloud.points.emplace_back(0.5F * i, 1.0F, -0.25F * i, 3U);
  LabelSet labels("own");
  ClassInfo lamp;
  lamp.id = 3;
  lamp.name = "lamp";
  lamp.kind = Kind::pole;
  labels.add(lamp);
  writeLas(folder_ / "a.las", cloud, &labels);
  const LabelledCloud read = readCloud(folder_ / "a.las");
  ASSERT_EQ(read.size(), cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i)
    EXPECT_LT((read.position(i) - cloud.position(i)).norm(), 1e-3);
  EXPECT_EQ(*readCloudHeader(folder_ / "a.las").labels, labels);
  cloud.points[2].label = 256;
  EXPECT_NE(test::messageOf<Error>([&] { writeLas(folder_ / "b.las", cloud); }).find("0 to 255"),
            std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "b.las"));
  cloud.points[2] = Point(1e9F, 0, 0, 1);
  EXPECT_NE(test::messageOf<Error>([&] { writeLas(folder_ / "b.las", cloud); }).find(".ply"),
            std::string::npos);
}

}  // namespace
}  // namespace xview::io
