// SPDX-License-Identifier: BSD-3-Clause
#include "cloud_builder.h"

#include <limits>

namespace xview {

void CloudBuilder::reserve(std::size_t points) { cloud_.points.reserve(points); }

void CloudBuilder::add(const Eigen::Vector3d& position, std::uint32_t label, std::uint32_t instance,
                       const RowPlace& place) {
  constexpr double kFarthest_m =
      1e12;  // beyond the planets: another type or byte order than the header says
  const double reach = position.cwiseAbs().maxCoeff();
  if (reach > kFarthest_m) place.fail("a coordinate beyond 1e12 m");
  if (reach > far_m_ && !has_origin_) setOrigin(position);
  Point point;
  point.getVector3fMap() = (position - cloud_.origin).cast<float>();
  point.label = label;
  point.instance = instance;
  cloud_.points.push_back(point);
}

void CloudBuilder::setOrigin(const Eigen::Vector3d& position) {
  has_origin_ = true;
  cloud_.origin = position.array().floor();
  for (Point& point : cloud_.points) {
    const Eigen::Vector3d old = point.getVector3fMap().cast<double>();
    point.getVector3fMap() = (old - cloud_.origin).cast<float>();
  }
}

void CloudBuilder::addRing(double ring) {
  constexpr double kMost = std::numeric_limits<std::uint16_t>::max();
  const bool is_ring = ring >= 0 && ring <= kMost;
  has_wrong_ring_ = has_wrong_ring_ || !is_ring;
  rings_.push_back(is_ring ? static_cast<std::uint16_t>(ring) : 0);
}

LabelledCloud CloudBuilder::finish() { return std::move(cloud_); }

std::vector<std::uint16_t> CloudBuilder::rings() const {
  return has_wrong_ring_ ? std::vector<std::uint16_t>() : rings_;
}

}  // namespace xview
