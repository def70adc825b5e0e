// SPDX-License-Identifier: BSD-3-Clause
#include "match/point_features.h"

#include <pcl/features/fpfh.h>
#include <pcl/features/normal_3d.h>

#include <cmath>

void xviewNormals(double radius, pcl::PointCloud<pcl::PointNormal>& points) {
  pcl::NormalEstimation<pcl::PointNormal, pcl::PointNormal> normal;
  normal.setInputCloud(points.makeShared());
  normal.setRadiusSearch(radius);
  pcl::PointCloud<pcl::PointNormal> normals;
  normal.compute(normals);
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i].normal_x = normals[i].normal_x;
    points[i].normal_y = normals[i].normal_y;
    points[i].normal_z = normals[i].normal_z;
  }
}

void xviewPointFeatures(const pcl::PointCloud<pcl::PointNormal>& points, double radius,
                        pcl::PointCloud<pcl::FPFHSignature33>& features) {
  const pcl::PointCloud<pcl::PointNormal>::ConstPtr shared = points.makeShared();
  pcl::FPFHEstimation<pcl::PointNormal, pcl::PointNormal, pcl::FPFHSignature33> fpfh;
  fpfh.setInputCloud(shared);
  fpfh.setInputNormals(shared);
  fpfh.setRadiusSearch(radius);
  fpfh.compute(features);
  for (pcl::FPFHSignature33& f : features) {
    for (float& bin : f.histogram) {
      if (!std::isfinite(bin)) bin = 0;
    }
  }
}
