// SPDX-License-Identifier: BSD-3-Clause
#include "sight.h"

#include <algorithm>
#include <cmath>

namespace xview {
namespace {

// Lengths of a town (types/semantic_place.h).
constexpr double kReach_m = 30;                   ///< to what is asked for
constexpr double kBlock_m = 2 * kReach_m;         ///< to what may lie behind it
constexpr double kSpacing_m = 1;                  ///< of the poses that are used
constexpr int kAzimuths = 120, kElevations = 60;  ///< of 3 degrees

ClassCell blockOf(const Eigen::Vector3d& p) { return cellOf(p, kBlock_m, 0); }

std::size_t directionOf(const Eigen::Vector3d& ray) {
  const double turn = std::atan2(ray.y(), ray.x()) / (2 * M_PI) + 0.5;
  const double rise = std::atan2(ray.z(), ray.head<2>().norm()) / M_PI + 0.5;
  const int azimuth = std::min(kAzimuths - 1, static_cast<int>(turn * kAzimuths));
  const int elevation = std::min(kElevations - 1, static_cast<int>(rise * kElevations));
  return static_cast<std::size_t>(elevation * kAzimuths + azimuth);
}

}  // namespace

Sight::Sight(const Place& place, const Eigen::AlignedBox3d& near) {
  for (const Eigen::Isometry3d& pose : place.poses) {
    const Eigen::Vector3d from = pose.translation();
    const bool is_new = panoramas_.empty() || (from - panoramas_.back().from).norm() >= kSpacing_m;
    if (is_new && near.contains(from))
      panoramas_.push_back({from, std::vector<Ranges>(kAzimuths * kElevations)});
  }
  for (std::size_t i = 0; i < panoramas_.size(); ++i)
    standpoints_.add(blockOf(panoramas_[i].from), i);
  for (std::size_t i = 0; i < place.cloud.size(); ++i) {
    const Eigen::Vector3d p = place.cloud.position(i);
    standpoints_.forAround(blockOf(p), [&](std::size_t at) {
      const Eigen::Vector3d ray = p - panoramas_[at].from;
      const double range = ray.norm();
      if (range > kBlock_m) return;
      const auto range_cm = static_cast<std::uint16_t>(std::max(1., 100 * range));
      Ranges& seen = panoramas_[at].ranges[directionOf(ray)];
      seen.nearest_cm = seen.farthest_cm == 0 ? range_cm : std::min(seen.nearest_cm, range_cm);
      seen.farthest_cm = std::max(seen.farthest_cm, range_cm);
    });
  }
}

Sight::Ray Sight::to(const Eigen::Vector3d& p, double margin_m) const {
  Ray best = Ray::open;
  standpoints_.anyAround(blockOf(p), [&](std::size_t at) {
    const Eigen::Vector3d ray = p - panoramas_[at].from;
    const double range = ray.norm();
    if (range > kReach_m) return false;
    const Ranges& seen = panoramas_[at].ranges[directionOf(ray)];
    if (seen.farthest_cm == 0) return false;
    const bool passes =
        seen.nearest_cm >= 100 * (range - margin_m) && seen.farthest_cm >= 100 * (range + margin_m);
    best = passes ? Ray::passes : Ray::blocked;
    return passes;
  });
  return best;
}

}  // namespace xview
