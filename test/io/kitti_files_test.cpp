// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>

#include "io/written_files.h"
#include "support/clouds.h"
#include "support/test_data.h"
#include "xview/io/cloud_files.h"

namespace xview {
namespace {

using test::raw;

class KittiScan : public ::testing::Test {
 protected:
  void write(const std::string& scan, const std::string& labels) const {
    test::writeBytes(scan_, scan);
    test::writeBytes(labels_, labels);
  }
  std::string error() const {
    return test::errorOf([&] { readKittiScan(scan_, labels_); });
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

TEST_F(KittiScan, AMissingLabelFileIsNamed) {
  test::writeBytes(scan_, point(1, 2, 3));
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
}  // namespace xview
