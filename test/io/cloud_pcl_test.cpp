// SPDX-License-Identifier: BSD-3-Clause
// What other programs on top of PCL see in our files, and what we see in theirs.
#include <gtest/gtest.h>
#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>

#include "base/random.h"
#include "support/test_data.h"
#include "xview/io/cloud_files.h"

namespace xview::io {
namespace {

LabelledCloud someCloud() {
  LabelledCloud cloud;
  Random random(5);
  for (int i = 0; i < 1000; ++i) {
    Point point;
    for (int axis = 0; axis < 3; ++axis)
      point.getVector3fMap()[axis] = static_cast<float>(random.uniform(-50, 50));
    point.label = random.below(20);
    cloud.points.push_back(point);
    cloud.points.back().instance = random.below(100);
  }
  return cloud;
}

void expectSameAsPcl(const pcl::PointCloud<pcl::PointXYZRGBL>& theirs, const LabelledCloud& ours,
                     const LabelSet& labels) {
  ASSERT_EQ(theirs.size(), ours.size());
  for (std::size_t i = 0; i < ours.size(); ++i) {
    const auto [red, green, blue] = labels.color(ours.points[i].label);
    ASSERT_EQ(theirs[i].getVector3fMap(), ours.points[i].getVector3fMap());
    ASSERT_EQ(theirs[i].label, ours.points[i].label);
    ASSERT_EQ(theirs[i].r, red);
    ASSERT_EQ(theirs[i].g, green);
    ASSERT_EQ(theirs[i].b, blue);
  }
}

TEST(PclPrograms, ReadOurPcdWithLabelsAndColors) {
  const test::TemporaryFolder folder;
  const LabelledCloud cloud = someCloud();
  const LabelSet labels = genericLabelSet({0, 1, 2, 3, 4});
  writePcd(folder / "a.pcd", cloud, &labels);
  pcl::PointCloud<pcl::PointXYZRGBL> read;
  ASSERT_EQ(pcl::io::loadPCDFile(folder / "a.pcd", read), 0);
  expectSameAsPcl(read, cloud, labels);
}

TEST(PclPrograms, ReadOurPlyWithLabelsAndColors) {
  const test::TemporaryFolder folder;
  const LabelledCloud cloud = someCloud();
  const LabelSet labels = genericLabelSet({0, 1, 2, 3, 4});
  writePly(folder / "a.ply", cloud, &labels);
  pcl::PointCloud<pcl::PointXYZRGBL> read;
  ASSERT_EQ(pcl::io::loadPLYFile(folder / "a.ply", read), 0);
  expectSameAsPcl(read, cloud, labels);
}

TEST(PclPrograms, WriteFilesThatWeRead) {
  const test::TemporaryFolder folder;
  const LabelledCloud cloud = someCloud();
  pcl::io::savePCDFileBinary(folder / "binary.pcd", cloud.points);
  pcl::io::savePCDFileBinaryCompressed(folder / "packed.pcd", cloud.points);
  pcl::io::savePCDFileASCII(folder / "ascii.pcd", cloud.points);
  pcl::io::savePLYFileBinary(folder / "binary.ply", cloud.points);
  pcl::io::savePLYFileASCII(folder / "ascii.ply", cloud.points);
  for (const std::string name :
       {"binary.pcd", "packed.pcd", "ascii.pcd", "binary.ply", "ascii.ply"}) {
    SCOPED_TRACE(name);
    const LabelledCloud read = readCloud(folder / name);
    const double tolerance = name.find("ascii") == 0 ? 1e-5 : 0;  // PCL writes 8 digits
    ASSERT_EQ(read.size(), cloud.size());
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      ASSERT_LE((read.position(i) - cloud.position(i)).norm(), tolerance);
      ASSERT_EQ(read.points[i].label, cloud.points[i].label);
    }
  }
}

}  // namespace
}  // namespace xview::io
