// SPDX-License-Identifier: BSD-3-Clause
#include "xview/sim/recordings.h"

#include <algorithm>
#include <cmath>

#include "xview/sim/option_check.h"
#include "xview/sim/route.h"
#include "xview/sim/town_labels.h"
#include "xview/sim/traffic.h"

namespace xview {
namespace {

constexpr double kLane = 1.4;     // from the middle of the road to the right [m]
constexpr double kSpeed = 9;      // [m/s]
constexpr double kTurn_s = 0.1;   // of the scanner
constexpr double kStart = 1.6e9;  // stamp of the first session [s]
constexpr double kFarAway = 1e5;  // truth of what is not in the map [m]
constexpr double kCameraHeight = 1.7, kLidarHeight = 1.8;
constexpr std::uint64_t kElsewhere = 0x454C5345;

enum SessionNumber {
  kForward,
  kForward2,
  kRear,
  kReverse,
  kOblique,
  kAerial,
  kElsewhereSession,
  kLidar,
  kLidarReverse,
  kLidarElsewhere
};

std::uint64_t sessionSeed(const SimulationOptions& options, int number) {
  return Random(static_cast<std::uint64_t>(options.seed), 100 + static_cast<std::uint64_t>(number))
      .next();
}

/// A town, a drive through it, and the sessions that record the drive.
class Stage {
 public:
  Stage(const SimulationOptions& options, std::uint64_t town_seed)
      : options_(options),
        town_(makeTown(seeded(options.town, town_seed))),
        static_scene_(std::make_shared<RayScene>(std::move(town_.mesh))),
        drive_(planDrive(town_.network, options.route_length_m, town_seed)) {}

  /// Sensor poses along the drive, `left_m` to its left, in the body frame (x ahead).
  std::vector<Eigen::Isometry3d> poses(const Polyline& line, double left_m, const Mount& mount,
                                       int number) const {
    return bodyPoses(shifted(line, left_m), options_.frame_spacing_m, mount, town_.relief,
                     sessionSeed(options_, number));
  }

  const Polyline& drive() const { return drive_; }

  /// A session on a day of its own.
  std::unique_ptr<SimulatedRecording> record(SessionPlan plan, int number) const {
    plan.seed = sessionSeed(options_, number);
    plan.start_s = kStart + 86400.0 * number;
    plan.period_s = options_.frame_spacing_m / kSpeed;
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

Mount cameraMount(double yaw_rad) {
  Mount mount;
  mount.height_m = kCameraHeight;
  mount.yaw_rad = yaw_rad;
  return mount;
}

Mount aerialMount(const AerialOptions& options) {
  Mount mount;
  mount.height_m = options.altitude_m;
  mount.pitch_rad = (90 - options.tilt_deg) * M_PI / 180;
  mount.sway_rad = 0.03;
  mount.follows_slope = false;
  mount.rise_m = 2;
  return mount;
}

Mount lidarMount() {
  Mount mount;
  mount.height_m = kLidarHeight;
  return mount;
}

/// Makes the sessions one after the other, all in the map frame of the first.
class SessionMaker {
 public:
  explicit SessionMaker(const SimulationOptions& options)
      : options_(options), stage_(options, static_cast<std::uint64_t>(options.seed)) {}

  std::vector<std::unique_ptr<SimulatedRecording>> make() {
    const SessionChoice& choice = options_.sessions;
    addCamera("forward", kForward, stage_.drive(), -kLane, cameraMount(0));
    if (choice.forward2)
      addCamera("forward2", kForward2, stage_.drive(), -kLane + 0.25, cameraMount(0));
    if (choice.rear) addCamera("rear", kRear, stage_.drive(), -kLane - 0.15, cameraMount(M_PI));
    if (choice.reverse) {
      addCamera("reverse", kReverse, reversed(stage_.drive()), -kLane, cameraMount(0));
    }
    if (choice.oblique) addCamera("oblique", kOblique, stage_.drive(), -kLane, cameraMount(0.9));
    if (choice.aerial)
      addCamera("aerial", kAerial, stage_.drive(), 3, aerialMount(options_.aerial));
    if (choice.lidar) {
      finish(lidarPlan(stage_, "lidar", kLidar, stage_.drive()), kLidar);
      finish(lidarPlan(stage_, "lidar_reverse", kLidarReverse, reversed(stage_.drive())),
             kLidarReverse);
    }
    if (choice.elsewhere) addElsewhere(choice.lidar);
    return std::move(sessions_);
  }

 private:
  SessionPlan cameraPlan(const Stage& stage, const std::string& name, int number,
                         const Polyline& line, double left_m, const Mount& mount) const {
    SessionPlan plan;
    plan.name = name;
    plan.sensor = Sensor::camera;
    plan.camera = pinholeCamera(options_.width, options_.height, options_.view_deg * M_PI / 180);
    plan.camera.depth_scale = 0.01;
    plan.depth_noise = options_.depth_noise;
    if (number == kAerial) plan.depth_noise.baseline_m = options_.aerial.baseline_m;
    for (const Eigen::Isometry3d& T : stage.poses(line, left_m, mount, number)) {
      plan.T_world_sensor.push_back(opticalPose(T));
    }
    return plan;
  }

  void addCamera(const std::string& name, int number, const Polyline& line, double left_m,
                 const Mount& mount) {
    finish(cameraPlan(stage_, name, number, line, left_m, mount), number);
  }

  SessionPlan lidarPlan(const Stage& stage, const std::string& name, int number,
                        const Polyline& line) const {
    SessionPlan plan;
    plan.name = name;
    plan.sensor = Sensor::lidar;
    plan.lidar = options_.lidar;
    plan.metres_per_turn = kSpeed * kTurn_s;
    plan.T_world_sensor = stage.poses(line, -kLane, lidarMount(), number);
    return plan;
  }

  void addElsewhere(bool with_lidar) {
    const Stage other(options_, static_cast<std::uint64_t>(options_.seed) ^ kElsewhere);
    addFarAway(
        other,
        cameraPlan(other, "elsewhere", kElsewhereSession, other.drive(), -kLane, cameraMount(0)),
        kElsewhereSession);
    if (with_lidar) {
      addFarAway(other, lidarPlan(other, "lidar_elsewhere", kLidarElsewhere, other.drive()),
                 kLidarElsewhere);
    }
  }

  void addFarAway(const Stage& other, SessionPlan plan, int number) {
    locate(plan, number);
    for (Eigen::Isometry3d& T : plan.T_map_sensor)
      T.pretranslate(Eigen::Vector3d(kFarAway, kFarAway, 0));
    sessions_.push_back(other.record(std::move(plan), number));
  }

  void finish(SessionPlan plan, int number) {
    locate(plan, number);
    sessions_.push_back(stage_.record(std::move(plan), number));
  }

  /// Odometry and truth from the poses in the world.
  void locate(SessionPlan& plan, int number) {
    const bool is_mapping_drive = number == kForward || number == kLidar;
    const double drift = options_.isNoisy() && !is_mapping_drive ? options_.drift : 0;
    plan.T_odom_sensor = asOdometry(plan.T_world_sensor, drift, sessionSeed(options_, number));
    if (number == kForward) {
      T_map_world_ = plan.T_odom_sensor.front() * plan.T_world_sensor.front().inverse();
    }
    for (const Eigen::Isometry3d& T : plan.T_world_sensor) {
      plan.T_map_sensor.push_back(T_map_world_ * T);
    }
    if (number == kLidar) plan.T_odom_sensor = plan.T_map_sensor;
  }

  const SimulationOptions& options_;
  Stage stage_;
  Eigen::Isometry3d T_map_world_ = Eigen::Isometry3d::Identity();
  std::vector<std::unique_ptr<SimulatedRecording>> sessions_;
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
    const double turns_per_step = options_.frame_spacing_m / plan_.metres_per_turn;
    frame = withOwnMotion(std::move(frame), step,
                          options_.lidar_noise.uncorrected_motion / turns_per_step);
  }
  return withLidarNoise(std::move(frame), options_.lidar_noise, plan_.seed);
}

Frame SimulatedRecording::read(std::size_t index) const {
  const Eigen::Isometry3d& T_world_sensor = plan_.T_world_sensor.at(index);
  const bool is_lidar = plan_.sensor == Sensor::lidar;
  Frame frame = is_lidar ? renderer_.renderLidar(plan_.lidar, T_world_sensor, options_.threads)
                         : renderer_.renderCamera(plan_.camera, T_world_sensor, options_.threads);
  frame.number = number(index);
  frame.stamp_s = stamp(index);
  frame.T_odom_sensor = pose(index);
  return options_.isNoisy() ? withNoise(std::move(frame), index) : frame;
}

std::vector<std::unique_ptr<SimulatedRecording>> makeSessions(const SimulationOptions& options) {
  SimulationOptions checked = options;
  visit(checked, OptionCheck());
  return SessionMaker(options).make();
}

}  // namespace xview
