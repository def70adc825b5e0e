// SPDX-License-Identifier: BSD-3-Clause
// A labelled point is a point of PCL: whatever takes a point type takes it.
#define PCL_NO_PRECOMPILE  // the templates are made for this point here
#include <gtest/gtest.h>
#include <pcl/common/transforms.h>
#include <pcl/features/normal_3d.h>
#include <pcl/filters/passthrough.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/io/pcd_io.h>
#include <pcl/registration/gicp.h>
#include <pcl/registration/icp.h>
#include <pcl/registration/ndt.h>
#include <pcl/segmentation/extract_clusters.h>

#include <cmath>
#include <sstream>

#include "support/test_data.h"
#include "xview/base/labelled_cloud.h"

namespace xview {
namespace {

using Cloud = pcl::PointCloud<Point>;

/// Three walls of a room, 10 cm between points, of class 7.
Cloud::Ptr corner() {
  auto cloud = std::make_shared<Cloud>();
  for (int i = 1; i <= 30; ++i) {
    for (int k = 1; k <= 30; ++k) {
      const auto a = 0.1F * static_cast<float>(i), b = 0.1F * static_cast<float>(k);
      for (const Point& p : {Point(a, b, 0, 7), Point(0, a, b, 7), Point(b, 0, a, 7)})
        cloud->push_back(p);
    }
  }
  return cloud;
}

Eigen::Affine3f smallMove() {
  return Eigen::Translation3f(0.04F, -0.03F, 0.02F) *
         Eigen::AngleAxisf(0.02F, Eigen::Vector3f::UnitZ());
}

TEST(PointOfPcl, IsLaidOutAsPclWantsIt) {
  static_assert(sizeof(Point) == 32 && alignof(Point) == 16);
  const Point point(1, 2, 3, 4);
  EXPECT_EQ(point.data[3], 1);
  EXPECT_EQ(point.y, point.getVector4fMap().y());
  EXPECT_EQ(point.getArray4fMap().z(), 3);
  std::ostringstream out;
  out << point;
  EXPECT_EQ(out.str(), "(1,2,3 - 4)");
}

TEST(PointOfPcl, IsTransformedFilteredAndClustered) {
  Cloud moved;
  pcl::transformPointCloud(*corner(), moved, smallMove().matrix());
  EXPECT_TRUE(moved[5].getVector3fMap().isApprox(smallMove() * (*corner())[5].getVector3fMap()));
  EXPECT_EQ(moved[5].label, 7u);

  Cloud thin, low;
  pcl::VoxelGrid<Point> voxels;
  voxels.setLeafSize(0.5F, 0.5F, 0.5F);
  voxels.setInputCloud(corner());
  voxels.filter(thin);
  EXPECT_LT(thin.size(), corner()->size() / 10);
  pcl::PassThrough<Point> pass;
  pass.setFilterFieldName("z");
  pass.setFilterLimits(-1, 0.05F);
  pass.setInputCloud(corner());
  pass.filter(low);
  EXPECT_EQ(low.size(), 900u);

  std::vector<pcl::PointIndices> clusters;
  pcl::EuclideanClusterExtraction<Point> extraction;
  extraction.setClusterTolerance(0.2);
  extraction.setInputCloud(corner());
  extraction.extract(clusters);
  EXPECT_EQ(clusters.size(), 1u);
}

TEST(PointOfPcl, HasNormalsAndIsWritten) {
  pcl::PointCloud<pcl::Normal> normals;
  pcl::NormalEstimation<Point, pcl::Normal> estimation;
  estimation.setInputCloud(corner());
  estimation.setKSearch(8);
  estimation.compute(normals);
  EXPECT_NEAR(std::abs(normals[3 * 465].normal_z), 1, 1e-3);

  const test::TemporaryFolder folder;
  ASSERT_EQ(pcl::PCDWriter().writeBinary(folder / "corner.pcd", *corner()), 0);
  Cloud read;
  ASSERT_EQ(pcl::io::loadPCDFile(folder / "corner.pcd", read), 0);
  ASSERT_EQ(read.size(), corner()->size());
  EXPECT_EQ(read[9].label, 7u);
}

template <class Registration>
void expectRegistered(Registration&& registration) {
  auto moved = std::make_shared<Cloud>();
  pcl::transformPointCloud(*corner(), *moved, smallMove().inverse().matrix());
  registration.setInputSource(moved);
  registration.setInputTarget(corner());
  Cloud aligned;
  registration.align(aligned);
  EXPECT_TRUE(registration.hasConverged());
  const Eigen::Vector3f off =
      (registration.getFinalTransformation() - smallMove().matrix()).template block<3, 1>(0, 3);
  EXPECT_LT(off.norm(), 0.03F);
}

TEST(PointOfPcl, IsRegistered) {
  pcl::IterativeClosestPoint<Point, Point> icp;
  icp.setMaxCorrespondenceDistance(0.3);
  expectRegistered(icp);
  pcl::GeneralizedIterativeClosestPoint<Point, Point> gicp;
  gicp.setMaxCorrespondenceDistance(0.3);
  expectRegistered(gicp);
  pcl::NormalDistributionsTransform<Point, Point> ndt;
  ndt.setResolution(1);
  expectRegistered(ndt);
}

}  // namespace
}  // namespace xview
