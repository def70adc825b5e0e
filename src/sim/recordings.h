// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/option_field.h"
#include "sim/office.h"
#include "sim/render.h"
#include "sim/sensor_noise.h"
#include "sim/town.h"
#include "xview/base/frame.h"

namespace xview {

/// What kind of world. Lengths and the angle of view that are left at their default take the value
/// that is usual for the style, such as frames 0.4 m apart in an office.
struct WorldStyle {
  std::string style = "suburb";
  double alike = 0;
  double changed = 0;
  bool hedges = false;
};

template <class Visitor>
void visit(WorldStyle& o, Visitor&& field) {
  field("style", o.style, Choices{{"suburb", "grid", "village", "campus", "office"}},
        "suburb = crooked streets of houses, grid = one street like the other, village = winding "
        "roads, campus = halls in open spaces, office = a floor of rooms and corridors with an "
        "RGB-D camera (never from the air)");
  field("alike", o.alike, Range{0, 1},
        "share of the lots and streets, or rooms, that follow one pattern, in this town and the "
        "other; in "
        "a grid at least 0.4");
  field("hedges", o.hedges, "hedges are a class of their own beside the rest of the vegetation");
  field("changed", o.changed, Range{0, 1},
        "share of the objects (poles, signs, lights; furniture) that were taken away, put up or "
        "moved after the mapping drives; changes.csv tells which");
}

/// Which recordings to make. `forward` is always there: its odometry frame is the map frame, and so
/// is that of `lidar`, the mapping drive of the scanner.
struct SessionChoice {
  bool forward2 = false;
  bool rear = true;
  bool reverse = false;
  bool oblique = false;
  bool aerial = true;
  bool elsewhere = false;
  bool lidar = false;
  bool winter = false;
  bool rear_now = false;
};

template <class Visitor>
void visit(SessionChoice& o, Visitor&& field) {
  field("forward2", o.forward2, "the same drive on another day, a little beside");
  field("rear", o.rear, "the same drive with the camera looking back");
  field("rear_now", o.rear_now, "a second camera on the car of forward, looking back");
  field("reverse", o.reverse, "the way back, on the other lane");
  field("oblique", o.oblique, "the same drive with the camera looking half to the left");
  field("winter", o.winter,
        "forward2 when every tree, hedge and sign is gone, and nobody is about; not in an office");
  field("aerial", o.aerial, "the same streets from the air");
  field(
      "elsewhere", o.elsewhere,
      "a drive in another town, which must not be found in the map; with aerial, from the air too");
  field("lidar", o.lidar,
        "LiDAR scans of the drive and of the way back; with --sessions.elsewhere, of the other "
        "town as well");
}

struct AerialOptions {
  double altitude_m = 45;
  double tilt_deg = 15;   ///< from straight down, towards the direction of flight
  double baseline_m = 1;  ///< noisy: of its two eyes; wings are wider than cars
};

template <class Visitor>
void visit(AerialOptions& o, Visitor&& field) {
  field("altitude_m", o.altitude_m, Range{10, 300},
        "height of the aerial camera above the road [m]");
  field("tilt_deg", o.tilt_deg, Range{0, 60},
        "aerial camera: 0 = straight down, more = ahead [deg]");
}

struct SimulationOptions {
  int seed = 1;
  int threads = 0;
  std::string quality = "clean";
  double route_length_m = 300;
  double frame_spacing_m = 2;
  int width = 320;
  int height = 240;
  double view_deg = 90;
  double drift = 0.01;
  WorldStyle sim;
  SessionChoice sessions;
  AerialOptions aerial;
  TownOptions town;
  OfficeOptions office;
  LidarModel lidar;
  DepthNoise depth_noise;
  LabelNoise label_noise;
  LidarNoise lidar_noise;

  bool isNoisy() const { return quality == "noisy"; }
};

template <class Visitor>
void visit(SimulationOptions& o, Visitor&& field) {
  field("seed", o.seed, Range{0, 2147483647}, "seed of the town and of everything random");
  field("threads", o.threads, Range{0, 1024},
        "threads; 0 = all cores. Results do not depend on it");
  field("quality", o.quality, Choices{{"clean", "labels", "noisy"}},
        "clean = perfect depth, labels and odometry; labels = as a network gives labels; noisy = "
        "depth and odometry as of a stereo camera and wheels as well");
  field("route_length_m", o.route_length_m, Range{10, 20000}, "length of the drive [m]");
  field("frame_spacing_m", o.frame_spacing_m, Range{0.1, 50}, "distance between frames [m]");
  field("width", o.width, Range{16, 8192}, "image width [pixels]");
  field("height", o.height, Range{16, 8192}, "image height [pixels]");
  field("view_deg", o.view_deg, Range{20, 150}, "horizontal angle of view [deg]");
  field("drift", o.drift, Range{0, 0.2},
        "noisy: error of the odometry per distance; the mapping drives have none, as after "
        "optimisation");
  field.group("sim", o.sim);
  field.group("sessions", o.sessions);
  field.group("aerial", o.aerial);
  field.group("lidar", o.lidar);
  field.group("label_noise", o.label_noise);
}

/// What a session is made of; SimulatedRecording renders it.
struct SessionPlan {
  std::string name;
  Sensor sensor = Sensor::camera;
  Camera camera;
  LabelSet labels;
  DepthNoise depth_noise;
  double nearest_m = 0, farthest_m = 1e9;  ///< depths that the camera can measure
  double speed = 9;                        ///< [m/s]
  double start_s = 0;                      ///< stamp of the first frame
  double period_s = 0;                     ///< between frames
  std::uint64_t seed = 0;
  std::vector<Eigen::Isometry3d> T_world_sensor;
  std::vector<Eigen::Isometry3d> T_odom_sensor;  ///< what the odometry says
  std::vector<Eigen::Isometry3d> T_map_sensor;   ///< the truth
};

/// A recording whose frames are rendered when they are read; any order, any thread, always the same
/// bytes.
class SimulatedRecording : public FrameSource {
 public:
  SimulatedRecording(SessionPlan plan, Renderer renderer, const SimulationOptions& options);

  std::size_t size() const override { return plan_.T_world_sensor.size(); }
  Eigen::Isometry3d pose(std::size_t index) const override { return plan_.T_odom_sensor.at(index); }
  double stamp(std::size_t index) const override {
    return plan_.start_s + plan_.period_s * static_cast<double>(index);
  }
  std::int64_t number(std::size_t index) const override { return static_cast<std::int64_t>(index); }
  Frame read(std::size_t index) const override;
  Sensor sensor() const override { return plan_.sensor; }
  const LabelSet& labels() const override { return plan_.labels; }
  const std::string& name() const override { return plan_.name; }

  /// T_map_sensor, with the map in the frame of the first session's odometry. A session from
  /// elsewhere is nowhere in the map: its truth lies 100 km off.
  Eigen::Isometry3d truth(std::size_t index) const { return plan_.T_map_sensor.at(index); }
  const Camera& camera() const { return plan_.camera; }  ///< camera sessions only

 private:
  Frame withNoise(Frame frame, std::size_t index) const;

  SessionPlan plan_;
  Renderer renderer_;
  SimulationOptions options_;
};

/// What happened to an object, or to one class of its parts, between the mapping drives and all
/// other sessions. Map frame.
struct ObjectChange {
  enum class What { gone, added, moved };
  What what = What::gone;
  std::string class_name;
  Eigen::Vector3d foot = Eigen::Vector3d::Zero();   ///< where it stands, or stood before [m]
  Eigen::Vector3d later = Eigen::Vector3d::Zero();  ///< where it stands after it was moved [m]
};

/// The chosen sessions, `forward` first. Each has its own traffic, odometry frame and noise; all
/// but `elsewhere` share the town. Throws UsageError if an option is out of range.
/// `changes` tells what sim.changed did.
std::vector<std::unique_ptr<SimulatedRecording>> makeSessions(
    const SimulationOptions& options, std::vector<ObjectChange>* changes = nullptr);

}  // namespace xview
