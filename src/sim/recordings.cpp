// SPDX-License-Identifier: BSD-3-Clause
#include "xview/sim/recordings.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "option_check.h"
#include "xview/sim/route.h"

namespace xview {
namespace {

constexpr double kLane = 1.4;     // from the middle of the road to the right [m]
constexpr double kSpeed = 9;      // [m/s]
constexpr double kTurn_s = 0.1;   // of the scanner
constexpr double kStart = 1.6e9;  // stamp of the first session [s]
constexpr double kFarAway = 1e5;  // truth of what is not in the map [m]
constexpr double kCameraHeight = 1.7, kLidarHeight = 1.8;
constexpr std::uint64_t kElsewhere = 0x454C5345;

/// One of the recordings that can be made.
struct SessionKind {
  const char* name;
  bool wanted;
  std::uint64_t number;  ///< of its seed and of its day
  Sensor sensor;
  Mount mount;
  double left_m = -kLane;  ///< from the middle of the road
  bool is_way_back = false, is_elsewhere = false;

  /// Its odometry is as after optimisation.
  bool isMappingDrive() const { return number == kForward || number == kLidar; }

  static constexpr std::uint64_t kForward = 0, kAerial = 5, kLidar = 7;
};

Mount mountAt(double height_m, double yaw_rad = 0) {
  Mount mount;
  mount.height_m = height_m;
  mount.yaw_rad = yaw_rad;
  return mount;
}

Mount aerialMount(const AerialOptions& options) {
  Mount mount = mountAt(options.altitude_m);
  mount.pitch_rad = (90 - options.tilt_deg) * M_PI / 180;
  mount.sway_rad = 0.03;
  mount.follows_slope = false;
  mount.rise_m = 2;
  return mount;
}

std::vector<SessionKind> sessionKinds(const SimulationOptions& options) {
  const SessionChoice& choice = options.sessions;
  const Mount ahead = mountAt(kCameraHeight), scanner = mountAt(kLidarHeight);
  const Mount back = mountAt(kCameraHeight, M_PI), aside = mountAt(kCameraHeight, 0.9);
  const Mount aerial = aerialMount(options.aerial);
  const bool lidar_elsewhere = choice.lidar && choice.elsewhere;
  return {
      {"forward", true, SessionKind::kForward, Sensor::camera, ahead},
      {"forward2", choice.forward2, 1, Sensor::camera, ahead, -kLane + 0.25},
      {"rear", choice.rear, 2, Sensor::camera, back, -kLane - 0.15},
      {"reverse", choice.reverse, 3, Sensor::camera, ahead, -kLane, true},
      {"oblique", choice.oblique, 4, Sensor::camera, aside},
      {"aerial", choice.aerial, SessionKind::kAerial, Sensor::camera, aerial, 3},
      {"lidar", choice.lidar, SessionKind::kLidar, Sensor::lidar, scanner},
      {"lidar_reverse", choice.lidar, 8, Sensor::lidar, scanner, -kLane, true},
      {"elsewhere", choice.elsewhere, 6, Sensor::camera, ahead, -kLane, false, true},
      {"lidar_elsewhere", lidar_elsewhere, 9, Sensor::lidar, scanner, -kLane, false, true},
  };
}

/// A town, a drive through it, and the sessions that record the drive.
class Stage {
 public:
  Stage(const SimulationOptions& options, std::uint64_t town_seed)
      : options_(options),
        town_(makeTown(seeded(options.town, town_seed))),
        static_scene_(std::make_shared<RayScene>(std::move(town_.mesh))),
        drive_(planDrive(town_.network, options.route_length_m, town_seed)) {}

  /// All but what the odometry says and the truth.
  SessionPlan plan(const SessionKind& kind) const {
    SessionPlan plan;
    plan.name = kind.name;
    plan.sensor = kind.sensor;
    plan.seed = Random(static_cast<std::uint64_t>(options_.seed), 100 + kind.number).next();
    plan.start_s = kStart + 86400.0 * static_cast<double>(kind.number);
    plan.period_s = options_.frame_spacing_m / kSpeed;
    const Polyline line = shifted(kind.is_way_back ? reversed(drive_) : drive_, kind.left_m);
    plan.T_world_sensor =
        bodyPoses(line, options_.frame_spacing_m, kind.mount, town_.relief, plan.seed);
    if (kind.sensor == Sensor::camera) {
      plan.camera = pinholeCamera(options_.width, options_.height, options_.view_deg * M_PI / 180);
      plan.camera.depth_scale = 0.01;
      plan.depth_noise = options_.depth_noise;
      if (kind.number == SessionKind::kAerial) {
        plan.depth_noise.baseline_m = options_.aerial.baseline_m;
      }
      for (Eigen::Isometry3d& T : plan.T_world_sensor) T = opticalPose(T);
    }
    return plan;
  }

  /// On a day of its own.
  std::unique_ptr<SimulatedRecording> record(SessionPlan plan) const {
    auto traffic = std::make_shared<RayScene>(makeTraffic(town_, plan.seed));
    const Renderer renderer({static_scene_, std::move(traffic)});
    return std::make_unique<SimulatedRecording>(std::move(plan), renderer, options_);
  }

 private:
  static TownOptions seeded(TownOptions town, std::uint64_t seed) {
    town.seed = seed;
    return town;
  }

  const SimulationOptions& options_;
  Town town_;
  std::shared_ptr<const RayScene> static_scene_;
  Polyline drive_;
};

}  // namespace

SimulatedRecording::SimulatedRecording(SessionPlan plan, Renderer renderer,
                                       const SimulationOptions& options)
    : plan_(std::move(plan)),
      renderer_(std::move(renderer)),
      options_(options),
      labels_(townLabels()) {}

Frame SimulatedRecording::withNoise(Frame frame, std::size_t index) const {
  if (plan_.sensor == Sensor::camera) {
    frame = withLabelNoise(std::move(frame), options_.label_noise, plan_.seed);
    return withDepthNoise(std::move(frame), plan_.depth_noise, plan_.seed);
  }
  if (size() > 1) {
    const std::size_t first = std::min(index, size() - 2);
    const Eigen::Isometry3d step =
        plan_.T_world_sensor[first].inverse() * plan_.T_world_sensor[first + 1];
    const double turns_per_step = options_.frame_spacing_m / (kSpeed * kTurn_s);
    frame = withOwnMotion(std::move(frame), step,
                          options_.lidar_noise.uncorrected_motion / turns_per_step);
  }
  return withLidarNoise(std::move(frame), options_.lidar_noise, plan_.seed);
}

Frame SimulatedRecording::read(std::size_t index) const {
  const Eigen::Isometry3d& T_world_sensor = plan_.T_world_sensor.at(index);
  const bool is_lidar = plan_.sensor == Sensor::lidar;
  Frame frame = is_lidar ? renderer_.renderLidar(options_.lidar, T_world_sensor, options_.threads)
                         : renderer_.renderCamera(plan_.camera, T_world_sensor, options_.threads);
  frame.number = number(index);
  frame.stamp_s = stamp(index);
  frame.T_odom_sensor = pose(index);
  return options_.isNoisy() ? withNoise(std::move(frame), index) : frame;
}

std::vector<std::unique_ptr<SimulatedRecording>> makeSessions(const SimulationOptions& options) {
  SimulationOptions checked = options;
  visit(checked, OptionCheck());
  const auto seed = static_cast<std::uint64_t>(options.seed);
  const Stage town(options, seed);
  std::optional<Stage> other_town;
  if (options.sessions.elsewhere) other_town.emplace(options, seed ^ kElsewhere);

  std::vector<std::unique_ptr<SimulatedRecording>> sessions;
  Eigen::Isometry3d T_map_world = Eigen::Isometry3d::Identity();
  for (const SessionKind& kind : sessionKinds(options)) {
    if (!kind.wanted) continue;
    const Stage& stage = kind.is_elsewhere ? *other_town : town;
    SessionPlan plan = stage.plan(kind);
    const double drift = options.isNoisy() && !kind.isMappingDrive() ? options.drift : 0;
    plan.T_odom_sensor = asOdometry(plan.T_world_sensor, drift, plan.seed);
    if (kind.number == SessionKind::kForward) {
      T_map_world = plan.T_odom_sensor.front() * plan.T_world_sensor.front().inverse();
    }
    for (const Eigen::Isometry3d& T : plan.T_world_sensor) {
      plan.T_map_sensor.push_back(T_map_world * T);
    }
    if (kind.number == SessionKind::kLidar) plan.T_odom_sensor = plan.T_map_sensor;
    if (kind.is_elsewhere) {
      const Eigen::Vector3d far_away(kFarAway, kFarAway, 0);
      for (Eigen::Isometry3d& T : plan.T_map_sensor) T.pretranslate(far_away);
    }
    sessions.push_back(stage.record(std::move(plan)));
  }
  return sessions;
}

}  // namespace xview
