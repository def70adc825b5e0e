// SPDX-License-Identifier: BSD-3-Clause
#include "xview/sim/site.h"

#include <algorithm>
#include <cmath>

namespace xview {
namespace {

constexpr double kHouseGap = 1.0;           // between houses [m]
constexpr double kHouseFromSidewalk = 1.0;  // [m]

/// True if the axes of `a` separate the rectangles.
bool axesSeparate(const Footprint& a, const Footprint& b, double gap_m) {
  const Eigen::Rotation2Dd to_a(-a.yaw);
  Eigen::AlignedBox2d box;
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {-0.5, 0.5}) {
      box.extend(to_a * (b.toWorld({x * b.size.x(), y * b.size.y()}) - a.center));
    }
  }
  const Eigen::Vector2d half = a.size / 2 + Eigen::Vector2d::Constant(gap_m);
  return box.min().x() > half.x() || box.max().x() < -half.x() || box.min().y() > half.y() ||
         box.max().y() < -half.y();
}

}  // namespace

Eigen::Vector2d Footprint::toWorld(const Eigen::Vector2d& p) const {
  return center + Eigen::Rotation2Dd(yaw) * p;
}

double Footprint::distanceTo(const Eigen::Vector2d& p) const {
  const Eigen::Vector2d local = Eigen::Rotation2Dd(-yaw) * (p - center);
  return (local.cwiseAbs() - size / 2).cwiseMax(0).norm();
}

bool overlap(const Footprint& a, const Footprint& b, double gap_m) {
  if ((a.center - b.center).norm() > (a.size.norm() + b.size.norm()) / 2 + 1.5 * gap_m)
    return false;
  return !axesSeparate(a, b, gap_m) && !axesSeparate(b, a, gap_m);
}

Eigen::Vector3d Site::onGround(const Eigen::Vector2d& p) const {
  return {p.x(), p.y(), groundHeight(relief, field, p)};
}

bool Site::isFree(const Eigen::Vector2d& p, double from_sidewalk_m, double from_house_m) const {
  if (field.toSidewalk(p) < from_sidewalk_m || field.toRoad(p) < from_sidewalk_m) return false;
  return std::none_of(houses.begin(), houses.end(),
                      [&](const Footprint& house) { return house.distanceTo(p) < from_house_m; });
}

bool Site::hasRoomFor(const Footprint& house) const {
  for (int i = -2; i <= 2; ++i) {
    for (int j = -2; j <= 2; ++j) {
      const Eigen::Vector2d p = house.toWorld({i * house.size.x() / 4, j * house.size.y() / 4});
      if (field.toSidewalk(p) < kHouseFromSidewalk) return false;
    }
  }
  return std::none_of(houses.begin(), houses.end(),
                      [&](const Footprint& other) { return overlap(house, other, kHouseGap); });
}

}  // namespace xview
