// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_builder.h"

namespace xview {

void CloudBuilder::reserve(std::size_t points) {
  cloud_.points.reserve(points);
  if (has_instances_) cloud_.instances.reserve(points);
}

void CloudBuilder::add(const Eigen::Vector3d& position, std::uint32_t label, std::uint32_t instance,
                       const RowPlace& place) {
  constexpr double kFarthest_m =
      1e12;  // beyond the planets: another type or byte order than the header says
  const double reach = position.cwiseAbs().maxCoeff();
  if (reach > kFarthest_m) place.fail("a coordinate beyond 1e12 m");
  if (reach > far_m_ && !has_origin_) setOrigin(position);
  pcl::PointXYZL point;
  point.getVector3fMap() = (position - cloud_.origin).cast<float>();
  point.label = label;
  cloud_.points.push_back(point);
  if (has_instances_) cloud_.instances.push_back(instance);
}

void CloudBuilder::setOrigin(const Eigen::Vector3d& position) {
  has_origin_ = true;
  cloud_.origin = position.array().floor();
  for (pcl::PointXYZL& point : cloud_.points) {
    const Eigen::Vector3d old = point.getVector3fMap().cast<double>();
    point.getVector3fMap() = (old - cloud_.origin).cast<float>();
  }
}

LabelledCloud CloudBuilder::finish() { return std::move(cloud_); }

}  // namespace xview
