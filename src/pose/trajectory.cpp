// SPDX-License-Identifier: BSD-3-Clause
#include "pose/trajectory.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/pose.h"

namespace xview::pose {
namespace {

/// How much longer than the odometry says the way was that fixes found; 1 if they found none.
double lengthRate(const std::vector<TrajectoryFix>& fixes,
                  const std::vector<double>& way_by_odometry) {
  double found = 0, by_odometry = 0;
  for (const TrajectoryFix& fix : fixes) {
    if (fix.way.empty()) continue;
    const std::size_t first = fix.index + 1 - fix.way.size();
    found += pathLengths(fix.way).back();
    by_odometry += fix.scale * (way_by_odometry[fix.index] - way_by_odometry[first]);
  }
  return found > 0 && by_odometry > 0 ? found / by_odometry : 1;
}

/// Where a fix puts a frame: where it was found with it, or as far from there as odometry says,
/// whose lengths are multiplied by `rate`.
Eigen::Isometry3d inMap(const TrajectoryFix& fix,
                        const std::vector<Eigen::Isometry3d>& T_odom_sensor, std::size_t i,
                        double rate) {
  const auto step = [&](std::size_t from) {
    Eigen::Isometry3d T = T_odom_sensor[from].inverse() * T_odom_sensor[i];
    T.translation() *= fix.scale * rate;
    return T;
  };
  if (fix.way.empty()) return fix.T_map_sensor * step(fix.index);
  const std::size_t first = fix.index + 1 - fix.way.size();
  if (i < first) return fix.way.front() * step(first);
  return i > fix.index ? fix.way.back() * step(fix.index) : fix.way[i - first];
}

}  // namespace

TrajectoryFix fixOf(const Localization& answer, std::size_t index) {
  return {index,
          answer.T_map_query,
          answer.T_map_sensor,
          answer.scale,
          answer.covariance,
          answer.confidence,
          answer.trajectory};
}

double offBetween(const TrajectoryFix& a, const TrajectoryFix& b,
                  const std::vector<Eigen::Isometry3d>& T_odom_sensor) {
  const Eigen::Isometry3d T_a_b = T_odom_sensor[a.index].inverse() * T_odom_sensor[b.index];
  const Eigen::Vector3d expected = a.T_map_sensor * (a.scale * T_a_b.translation());
  return (b.T_map_sensor.translation() - expected).norm();
}

double sigmaBetween(const TrajectoryFix& a, const TrajectoryFix& b) {
  return std::sqrt(a.covariance.topLeftCorner<3, 3>().trace() +
                   b.covariance.topLeftCorner<3, 3>().trace());
}

std::vector<bool> toldByOdometry(const std::vector<TrajectoryFix>& fixes,
                                 const std::vector<Eigen::Isometry3d>& T_odom_sensor,
                                 const std::vector<double>& way_m, double size) {
  constexpr double kNear_m = 10, kWay_m = 25, kMostError = 0.05, kSigmas = 2;
  std::vector<bool> is_told(way_m.size(), false);
  const auto mark = [&](double from_m, double to_m, bool value) {
    for (std::size_t i = 0; i < way_m.size(); ++i) {
      if (way_m[i] >= from_m && way_m[i] <= to_m) is_told[i] = value;
    }
  };
  std::vector<std::pair<double, double>> bad;
  for (std::size_t a = 0, b = 0; a < fixes.size(); ++a) {
    const double from_m = way_m[fixes[a].index];
    mark(from_m - kNear_m * size, from_m + kNear_m * size, true);
    while (b < fixes.size() && way_m[fixes[b].index] - from_m < kWay_m * size) ++b;
    if (b == fixes.size()) continue;
    const double to_m = way_m[fixes[b].index];
    const double off_m =
        offBetween(fixes[a], fixes[b], T_odom_sensor) - kSigmas * sigmaBetween(fixes[a], fixes[b]);
    if (off_m <= kMostError * (to_m - from_m))
      mark(from_m, to_m, true);
    else
      bad.emplace_back(from_m, to_m);
  }
  for (const auto& [from_m, to_m] : bad) mark(from_m, to_m, false);
  return is_told;
}

std::vector<Eigen::Isometry3d> trajectoryThrough(
    const std::vector<Eigen::Isometry3d>& T_odom_sensor, const std::vector<TrajectoryFix>& fixes) {
  const std::vector<double> way = pathLengths(T_odom_sensor);
  const double rate = lengthRate(fixes, way);
  std::vector<Eigen::Isometry3d> poses;
  auto after = fixes.begin();  // the first fix that is not before the frame
  for (std::size_t i = 0; i < T_odom_sensor.size(); ++i) {
    while (after != fixes.end() && after->index < i) ++after;
    const TrajectoryFix& a = after == fixes.begin() ? *after : *(after - 1);
    const TrajectoryFix& b = after == fixes.end() ? *(after - 1) : *after;
    const double length = way[b.index] - way[a.index];
    const double share = length > 0 ? (way[i] - way[a.index]) / length : 1;
    poses.push_back(interpolated(inMap(a, T_odom_sensor, i, rate), inMap(b, T_odom_sensor, i, rate),
                                 std::clamp(share, 0.0, 1.0)));
  }
  return poses;
}

std::vector<std::optional<Eigen::Isometry3d>> trajectoryThrough(
    const std::vector<Eigen::Isometry3d>& T_odom_sensor, const std::vector<TrajectoryFix>& fixes,
    const std::vector<std::size_t>& jumps) {
  std::vector<std::optional<Eigen::Isometry3d>> poses(T_odom_sensor.size());
  for (std::size_t k = 0; k <= jumps.size(); ++k) {
    const std::size_t begin = k == 0 ? 0 : jumps[k - 1],
                      end = k == jumps.size() ? T_odom_sensor.size() : jumps[k];
    std::vector<TrajectoryFix> of_stretch;
    for (const TrajectoryFix& fix : fixes) {
      if (fix.index < begin || fix.index >= end) continue;
      of_stretch.push_back(fix);
      of_stretch.back().index -= begin;
    }
    if (of_stretch.empty()) continue;
    const auto stretch = trajectoryThrough(
        std::vector<Eigen::Isometry3d>(T_odom_sensor.begin() + static_cast<std::ptrdiff_t>(begin),
                                       T_odom_sensor.begin() + static_cast<std::ptrdiff_t>(end)),
        of_stretch);
    std::copy(stretch.begin(), stretch.end(), poses.begin() + static_cast<std::ptrdiff_t>(begin));
  }
  return poses;
}

Matrix6d movedCovariance(const Matrix6d& covariance, const Eigen::Vector3d& p_map,
                         const Eigen::Vector3d& to_map) {
  // d(to) = d(p) + d(theta) x (to - p)
  const Eigen::Vector3d v = to_map - p_map;
  Matrix6d J = Matrix6d::Identity();
  J.topRightCorner<3, 3>() << 0, v.z(), -v.y(), -v.z(), 0, v.x(), v.y(), -v.x(), 0;
  return J * covariance * J.transpose();
}

}  // namespace xview::pose
