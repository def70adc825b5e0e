// SPDX-License-Identifier: BSD-3-Clause
#include "sight.h"

#include <algorithm>
#include <cmath>

namespace xview {
namespace {

// Lengths of a town (base/semantic_place.h).
constexpr double kReach_m = 30;                   ///< to what is asked for
constexpr double kSightBlock_m = 2 * kReach_m;    ///< to what may lie behind it
constexpr double kSpacing_m = 1;                  ///< of the poses that are used
constexpr double kPoint_m = 0.18;                 ///< half the diagonal of a thinned voxel's face
constexpr double kFar_m = 14;                     ///< there it is a small part of a bin
constexpr int kAzimuths = 120, kElevations = 60;  ///< of 3 degrees
constexpr double kBin_rad = M_PI / kElevations;

ClassCell blockOf(const Eigen::Vector3d& p) { return cellOf(p, kSightBlock_m, 0); }

/// In bins of a panorama.
class Direction {
 public:
  explicit Direction(const Eigen::Vector3d& ray)
      : across_m_(ray.head<2>().norm()),
        azimuth_(kAzimuths * (std::atan2(ray.y(), ray.x()) / (2 * M_PI) + 0.5)),
        elevation_(kElevations * (std::atan2(ray.z(), across_m_) / M_PI + 0.5)) {}

  std::size_t bin() const { return binAt(floorToInt(azimuth_), floorToInt(elevation_)); }

  /// Calls visit(bin) for all bins that a ball of this radius around the point touches.
  template <class Visit>
  void forTouchedBy(double radius_m, double range_m, const Visit& visit) const {
    const double high = std::min(1., radius_m / range_m) / kBin_rad;
    const double wide =
        across_m_ > radius_m ? radius_m / across_m_ / kBin_rad : (kAzimuths - 1) / 2.;
    const int top = floorToInt(elevation_ + high), last = floorToInt(azimuth_ + wide);
    for (int e = floorToInt(elevation_ - high); e <= top; ++e) {
      for (int a = floorToInt(azimuth_ - wide); a <= last; ++a) visit(binAt(a, e));
    }
  }

 private:
  static std::size_t binAt(int azimuth, int elevation) {
    const int around = (azimuth + kAzimuths) % kAzimuths;
    return static_cast<std::size_t>(std::clamp(elevation, 0, kElevations - 1) * kAzimuths + around);
  }

  double across_m_;
  double azimuth_, elevation_;
};

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
      if (range > kSightBlock_m) return;
      const auto range_cm = static_cast<std::uint16_t>(std::max(1., 100 * range));
      const Direction direction(ray);
      std::vector<Ranges>& ranges = panoramas_[at].ranges;
      Ranges& seen = ranges[direction.bin()];
      seen.farthest_cm = std::max(seen.farthest_cm, range_cm);
      seen.nearest_cm = std::min(seen.nearest_cm, range_cm);
      if (range > kFar_m) return;
      direction.forTouchedBy(kPoint_m, range, [&](std::size_t bin) {
        ranges[bin].nearest_cm = std::min(ranges[bin].nearest_cm, range_cm);
      });
    });
  }
}

Sight::Ray Sight::to(const Eigen::Vector3d& p, double margin_m) const {
  Ray best = Ray::open;
  standpoints_.anyAround(blockOf(p), [&](std::size_t at) {
    const Eigen::Vector3d ray = p - panoramas_[at].from;
    const double range = ray.norm();
    if (range > kReach_m) return false;
    const Ranges& seen = panoramas_[at].ranges[Direction(ray).bin()];
    const bool is_hidden = seen.nearest_cm < 100 * (range - margin_m);
    if (!is_hidden && seen.farthest_cm == 0) return false;
    const bool passes = !is_hidden && seen.farthest_cm >= 100 * (range + margin_m);
    best = passes ? Ray::passes : Ray::blocked;
    return passes;
  });
  return best;
}

}  // namespace xview
