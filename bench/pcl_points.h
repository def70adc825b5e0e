// SPDX-License-Identifier: BSD-3-Clause
// What the benchmarks of PCL share.
#pragma once

#include <pcl/filters/voxel_grid.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <time.h>

#include "xview/base/labelled_cloud.h"

namespace xview {

using Points = pcl::PointCloud<pcl::PointXYZ>;

/// Of this process, all threads.
inline double cpuSeconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// The finite points of a cloud, relative to its origin, by PCL's voxel grid.
inline Points::Ptr thinned(const LabelledCloud& cloud, float leaf_m) {
  Points::Ptr all(new Points), thin(new Points);
  for (const Point& p : cloud.points) {
    if (p.getVector3fMap().allFinite()) all->push_back({p.x, p.y, p.z});
  }
  pcl::VoxelGrid<pcl::PointXYZ> grid;
  grid.setInputCloud(all);
  grid.setLeafSize(leaf_m, leaf_m, leaf_m);
  grid.filter(*thin);
  return thin;
}

}  // namespace xview
