// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "xview/sim/mesh.h"
#include "xview/types/frame.h"
#include "xview/types/option_field.h"

namespace xview {

/// A spinning LiDAR. Its frame: x forward, y left, z up.
struct LidarModel {
  int rings = 64;
  int azimuths = 1024;
  double lowest_deg = -24.8;
  double highest_deg = 2;
  double max_range_m = 80;
};

template <class Visitor>
void visit(LidarModel& o, Visitor&& field) {
  field("rings", o.rings, Range{1, 512}, "laser beams above one another");
  field("azimuths", o.azimuths, Range{8, 8192}, "measurements per turn");
  field("lowest_deg", o.lowest_deg, Range{-89, 89}, "elevation of the lowest beam [deg]");
  field("highest_deg", o.highest_deg, Range{-89, 89}, "elevation of the highest beam [deg]");
  field("max_range_m", o.max_range_m, Range{1, 1000}, "no return from further away [m]");
}

/// Triangles, ready to be met by rays.
class RayScene {
 public:
  explicit RayScene(TriangleMesh mesh);
  ~RayScene();
  RayScene(const RayScene&) = delete;
  RayScene& operator=(const RayScene&) = delete;

 private:
  friend class RayCaster;
  struct Bvh;
  TriangleMesh mesh_;
  std::unique_ptr<Bvh> bvh_;
};

/// Perfect sensors in one or more scenes (e.g. a town and the traffic of a day).
class Renderer {
 public:
  explicit Renderer(std::vector<std::shared_ptr<const RayScene>> scenes);

  /// Depth along the optical axis to the plane of the triangle, in double precision; label and
  /// instance of the pixel centres. Where nothing is hit: depth 0, label sky. T_odom_sensor of the
  /// frame is left at identity.
  Frame renderCamera(const Camera& camera, const Eigen::Isometry3d& T_world_camera,
                     int threads = 0) const;

  /// One scan without motion of the sensor, ring by ring from the lowest; beams without return are
  /// left out.
  Frame renderLidar(const LidarModel& lidar, const Eigen::Isometry3d& T_world_lidar,
                    int threads = 0) const;

 private:
  std::vector<std::shared_ptr<const RayScene>> scenes_;
};

/// A camera of this size with square pixels, its principal point in the middle.
Camera pinholeCamera(int width, int height, double horizontal_view_rad);

}  // namespace xview
