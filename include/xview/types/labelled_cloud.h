// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace xview {

/// Points with a class label each, and an instance if the data has them. Points are single
/// precision relative to `origin`, so that maps in UTM coordinates keep their millimetres: p_frame
/// = origin + p.
struct LabelledCloud {
  pcl::PointCloud<pcl::PointXYZL> points;
  std::vector<std::uint32_t> instances;  ///< empty, or one per point (0 = none)
  std::vector<float> ranges;             ///< empty, or the distance to the sensor when measured [m]
  std::vector<std::uint16_t> rings;  ///< empty, or the beam of the scanner, numbered in any order
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();

  std::size_t size() const { return points.size(); }
  bool empty() const { return points.empty(); }
  Eigen::Vector3d position(std::size_t i) const {
    return origin + points[i].getVector3fMap().cast<double>();
  }
};

}  // namespace xview
