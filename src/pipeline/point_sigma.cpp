// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/point_sigma.h"

namespace xview {

float rangeOf(const FrameDigest& frame, std::size_t i) {
  if (frame.sensor == Sensor::cloud) return 0;
  const Eigen::Vector3f sensor =
      (frame.T_odom_sensor.translation() - frame.cloud.origin).cast<float>();
  return (frame.cloud.points[i].getVector3fMap() - sensor).norm();
}

std::size_t appendKnownPoints(const FrameDigest& frame, double max_sigma_m, LabelledCloud& cloud) {
  const Eigen::Vector3f shift = (frame.cloud.origin - cloud.origin).cast<float>();
  const std::size_t before = cloud.points.size();
  for (Point point : frame.cloud.points) {
    if (!(double{point.sigma} <= max_sigma_m)) continue;
    point.getVector3fMap() += shift;
    point.instance = 0;  // numbers of two frames need not agree
    cloud.points.push_back(point);
  }
  return cloud.points.size() - before;
}

}  // namespace xview
