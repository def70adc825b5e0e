// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "voxel_thinner.h"
#include "xview/graph/blobs.h"

namespace xview {
namespace {

constexpr std::size_t kPointsAtOnce = 512;  ///< stay in the first cache

void gather(const LabelledCloud& cloud, std::size_t first, bool has_instances, bool has_ranges,
            PointRow& row) {
  row.size = std::min(kPointsAtOnce, cloud.size() - first);
  for (std::size_t i = 0; i < row.size; ++i) {
    const pcl::PointXYZL& point = cloud.points.points[first + i];
    row.x[i] = point.x, row.y[i] = point.y, row.z[i] = point.z;
    row.label[i] = point.label;
    if (has_instances) row.instance[i] = cloud.instances[first + i];
    if (has_ranges) row.range[i] = cloud.ranges[first + i];
  }
}

}  // namespace

LabelledCloud thinByVoxel(const LabelledCloud& cloud, double voxel_m,
                          std::vector<std::uint32_t>* points_per_voxel) {
  if (voxel_m <= 0) {
    if (points_per_voxel) points_per_voxel->assign(cloud.size(), 1);
    return cloud;
  }
  const bool has_instances = cloud.instances.size() == cloud.size();
  const bool has_ranges = cloud.ranges.size() == cloud.size();
  VoxelThinner thinner(cloud.origin, voxel_m, cloud.size());
  PointRow row(kPointsAtOnce);
  for (std::size_t first = 0; first < cloud.size(); first += row.size) {
    gather(cloud, first, has_instances, has_ranges, row);
    thinner.add(row);
  }
  return thinner.finish(has_instances, has_ranges, points_per_voxel);
}

}  // namespace xview
