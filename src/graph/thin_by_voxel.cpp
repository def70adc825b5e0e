// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "voxel_thinner.h"
#include "xview/graph/blobs.h"

namespace xview {
namespace {

constexpr std::size_t kPointsAtOnce = 512;  ///< stay in the first cache

void gather(const LabelledCloud& cloud, std::size_t first, PointRow& row) {
  row.size = std::min(kPointsAtOnce, cloud.size() - first);
  for (std::size_t i = 0; i < row.size; ++i) {
    const Point& point = cloud.points.points[first + i];
    row.x[i] = point.x, row.y[i] = point.y, row.z[i] = point.z;
    row.label[i] = point.label;
    row.instance[i] = point.instance;
    row.sigma[i] = point.sigma;
  }
}

}  // namespace

LabelledCloud thinByVoxel(const LabelledCloud& cloud, double voxel_m,
                          std::vector<std::uint32_t>* points_per_voxel) {
  if (voxel_m <= 0) {
    if (points_per_voxel) points_per_voxel->assign(cloud.size(), 1);
    return cloud;
  }
  VoxelThinner thinner(cloud.origin, voxel_m, cloud.size());
  PointRow row(kPointsAtOnce);
  for (std::size_t first = 0; first < cloud.size(); first += row.size) {
    gather(cloud, first, row);
    thinner.add(row);
  }
  return thinner.finish(points_per_voxel);
}

}  // namespace xview
