// SPDX-License-Identifier: BSD-3-Clause
#include "sim/route.h"

#include <algorithm>
#include <cmath>

#include "base/pose.h"
#include "base/random.h"

namespace xview {
namespace {

constexpr double kStep = 1;      // between points of a drive [m]
constexpr double kRounding = 6;  // corners are averaged over this far both ways [m]

/// Chooses streets one after the other.
class Driver {
 public:
  Driver(const StreetNetwork& network, std::uint64_t seed)
      : network_(network), visits_(network.streets.size(), 0), random_(seed, 11) {
    at_ = static_cast<int>(random_.below(static_cast<std::uint32_t>(network.junctions.size())));
  }

  Polyline drive(double length_m) {
    Polyline line;
    double driven = 0;
    while (driven < 1.1 * length_m + 2 * kRounding) {  // rounding corners shortens the way
      last_ = nextStreet();
      ++visits_[last_];
      const Street& street = network_.streets[last_];
      Polyline part = street.centreline;
      if (street.from != at_) std::reverse(part.begin(), part.end());
      at_ = street.from == at_ ? street.to : street.from;
      driven += ArcLength(part).length();
      line.insert(line.end(), part.begin() + (line.empty() ? 0 : 1), part.end());
    }
    return line;
  }

 private:
  /// One of the least visited streets here, but not the one we came on.
  int nextStreet() {
    std::vector<int> best;
    for (const int street : network_.junctions[at_].streets) {
      if (street == last_) continue;
      if (!best.empty() && visits_[street] < visits_[best[0]]) best.clear();
      if (best.empty() || visits_[street] == visits_[best[0]]) best.push_back(street);
    }
    return best[random_.below(static_cast<std::uint32_t>(best.size()))];
  }

  const StreetNetwork& network_;
  std::vector<int> visits_;
  Random random_;
  int at_ = 0, last_ = -1;
};

/// Points at this distance along the first `length_m` of a line.
Polyline resampled(const Polyline& line, double step_m, double length_m) {
  const ArcLength along(line);
  Polyline result;
  for (double s = 0; s <= std::min(length_m, along.length()); s += step_m) {
    result.push_back(along.at(s).position);
  }
  return result;
}

/// Mean over a window that shrinks towards the ends.
Polyline rounded(const Polyline& line) {
  const auto size = static_cast<int>(line.size());
  Polyline result;
  for (int i = 0; i < size; ++i) {
    const int reach = std::min({static_cast<int>(kRounding / kStep), i, size - 1 - i});
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (int j = i - reach; j <= i + reach; ++j) sum += line[j];
    result.push_back(sum / (2 * reach + 1));
  }
  return result;
}

/// Slow movements: a sum of two waves over the distance.
class Sway {
 public:
  explicit Sway(Random& random) {
    for (Wave& wave : waves_) {
      wave.phase = random.uniform(0, 2 * M_PI);
      wave.number = 2 * M_PI / random.uniform(7, 40);
    }
  }
  double at(double along_m) const {
    double sum = 0;
    for (const Wave& wave : waves_) sum += 0.5 * std::sin(wave.number * along_m + wave.phase);
    return sum;
  }

 private:
  struct Wave {
    double phase, number;
  };
  Wave waves_[2];
};

Eigen::AngleAxisd about(const Eigen::Vector3d& axis, double angle) { return {angle, axis}; }

}  // namespace

Polyline streetsThrough(const StreetNetwork& network, double length_m, std::uint64_t seed) {
  return Driver(network, seed).drive(length_m);
}

Polyline planDrive(const StreetNetwork& network, double length_m, std::uint64_t seed) {
  const Polyline line = streetsThrough(network, length_m, seed);
  return resampled(rounded(resampled(line, kStep, ArcLength(line).length())), kStep, length_m);
}

Polyline shifted(const Polyline& drive, double left_m) {
  Polyline line;
  for (std::size_t i = 0; i < drive.size(); ++i) {
    const Eigen::Vector2d before = drive[i > 0 ? i - 1 : 0];
    const Eigen::Vector2d direction =
        (drive[std::min(i + 1, drive.size() - 1)] - before).normalized();
    line.push_back(drive[i] + left_m * Eigen::Vector2d(-direction.y(), direction.x()));
  }
  return line;
}

Polyline reversed(Polyline drive) {
  std::reverse(drive.begin(), drive.end());
  return drive;
}

std::vector<Eigen::Isometry3d> bodyPoses(const Polyline& line, double spacing_m, const Mount& mount,
                                         const Relief& relief, std::uint64_t seed) {
  Random random(seed, 12);
  const Sway roll(random), pitch(random), rise(random);
  const ArcLength along(line);
  const auto wheel = [&](double s) {
    const Eigen::Vector2d p = along.at(s).position;
    return Eigen::Vector3d(p.x(), p.y(), relief.at(p) - kCurb);
  };
  std::vector<Eigen::Isometry3d> poses;
  for (double s = 0; s <= along.length(); s += spacing_m) {
    const Eigen::Vector3d axle = wheel(s + 1.3) - wheel(s - 1.3);
    const double slope = mount.follows_slope ? std::atan2(axle.z(), axle.head<2>().norm()) : 0;
    const double yaw = std::atan2(axle.y(), axle.x());
    const Eigen::Vector3d up(0, 0, mount.height_m + mount.rise_m * rise.at(s));
    Eigen::Isometry3d T = poseFromYaw(wheel(s) + up, yaw);
    T.rotate(about(Eigen::Vector3d::UnitY(), -slope + mount.sway_rad * pitch.at(s)));
    T.rotate(about(Eigen::Vector3d::UnitX(), mount.sway_rad * roll.at(s)));
    T.rotate(about(Eigen::Vector3d::UnitZ(), mount.yaw_rad));
    T.rotate(about(Eigen::Vector3d::UnitY(), mount.pitch_rad));
    poses.push_back(T);
  }
  return poses;
}

std::vector<Eigen::Isometry3d> carriedPoses(std::vector<Eigen::Isometry3d> T_world_body,
                                            const Mount& mount, double left_m, std::uint64_t seed) {
  Random random(seed, 12);
  const Sway roll(random), pitch(random), yaw(random);
  for (std::size_t i = 0; i < T_world_body.size(); ++i) {
    const auto step = static_cast<double>(i);  // a sway lasts for some steps
    Eigen::Isometry3d& T = T_world_body[i];
    T.translate(Eigen::Vector3d(0, left_m, mount.height_m));
    T.rotate(about(Eigen::Vector3d::UnitZ(), mount.yaw_rad + 2 * mount.sway_rad * yaw.at(step)));
    T.rotate(about(Eigen::Vector3d::UnitY(), mount.pitch_rad + mount.sway_rad * pitch.at(step)));
    T.rotate(about(Eigen::Vector3d::UnitX(), mount.sway_rad * roll.at(step)));
  }
  return T_world_body;
}

Eigen::Isometry3d opticalPose(const Eigen::Isometry3d& T_world_body) {
  Eigen::Isometry3d T_body_optical = Eigen::Isometry3d::Identity();
  T_body_optical.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return T_world_body * T_body_optical;
}

std::vector<Eigen::Isometry3d> asOdometry(const std::vector<Eigen::Isometry3d>& T_world_sensor,
                                          double drift, std::uint64_t seed) {
  Random random(seed, 13);
  const Eigen::Vector3d offset{random.uniform(-500, 500), random.uniform(-500, 500),
                               random.uniform(-50, 50)};
  const Eigen::Isometry3d T_odom_world = poseFromYaw(offset, random.uniform(-M_PI, M_PI));
  const auto sign = [&] { return random.uniform() < 0.5 ? -1.0 : 1.0; };
  // Half of the error is a wrong scale, half a bend that reaches the other half after 100 m.
  const double scale = 1 + 0.7 * drift * random.uniform(0.7, 1.3) * sign();
  const double bend = 2 * 0.7 * drift / 100 * random.uniform(0.7, 1.3) * sign();  // [rad/m]
  const double climb = 0.3 * drift * random.uniform(-1, 1);

  std::vector<Eigen::Isometry3d> T_odom_sensor;
  if (drift == 0) {  // exactly rigid, without the rounding of the sum below
    for (const auto& T : T_world_sensor) T_odom_sensor.push_back(T_odom_world * T);
    return T_odom_sensor;
  }
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  double yaw = 0;
  for (std::size_t i = 0; i < T_world_sensor.size(); ++i) {
    const Eigen::Isometry3d T = T_odom_world * T_world_sensor[i];
    if (i == 0) {
      position = T.translation();
    } else {
      const Eigen::Vector3d step =
          T.translation() - (T_odom_world * T_world_sensor[i - 1]).translation();
      position += scale * (about(Eigen::Vector3d::UnitZ(), yaw) * step);
      position.z() += climb * step.norm();
      yaw += bend * step.norm();
    }
    T_odom_sensor.push_back(poseOf(about(Eigen::Vector3d::UnitZ(), yaw) * T.linear(), position));
  }
  return T_odom_sensor;
}

}  // namespace xview
