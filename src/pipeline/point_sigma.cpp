// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/point_sigma.h"

namespace xview {

std::size_t appendKnownPoints(const FrameDigest& frame, double max_sigma_m, LabelledCloud& cloud,
                              std::vector<float>& sigmas_m) {
  const Eigen::Vector3f shift = (frame.cloud.origin - cloud.origin).cast<float>();
  const std::size_t before = cloud.points.size();
  for (std::size_t i = 0; i < frame.cloud.size(); ++i) {
    const double sigma_m = pointSigma(frame, i);
    if (!(sigma_m <= max_sigma_m)) continue;
    pcl::PointXYZL point = frame.cloud.points[i];
    point.getVector3fMap() += shift;
    cloud.points.push_back(point);
    sigmas_m.push_back(static_cast<float>(sigma_m));
  }
  return cloud.points.size() - before;
}

}  // namespace xview
