// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/option_field.h"
#include "base/random.h"
#include "xview/base/frame.h"

struct RTCSceneTy;  // of Embree

namespace xview {

/// What a surface shows in the label and the instance image.
struct Tag {
  std::uint16_t label = 0;
  std::uint16_t instance = 0;  ///< 0 = none
};

/// Triangles with a class each. World frame: x east, y north, z up [m].
struct TriangleMesh {
  struct Triangle {
    std::array<std::uint32_t, 3> corner{};
    Tag tag;
  };
  std::vector<Eigen::Vector3f> vertices;
  std::vector<Triangle> triangles;
};

void addTriangle(TriangleMesh& mesh, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                 const Eigen::Vector3d& c, Tag tag);

/// Corners in order around the quadrilateral.
void addQuad(TriangleMesh& mesh, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
             const Eigen::Vector3d& c, const Eigen::Vector3d& d, Tag tag);

/// A box that stands on z = 0 of its own frame, centred in x and y. Its top is scaled about its
/// axis by `taper` in x and y: car cabins, hipped roofs.
void addBox(TriangleMesh& mesh, const Eigen::Isometry3d& T_world_box, const Eigen::Vector3d& size,
            Tag tag, const Eigen::Vector2d& taper = Eigen::Vector2d::Ones());

/// A (cut) cone or cylinder with closed ends from `from` to `to`.
void addTube(TriangleMesh& mesh, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
             double radius_from, double radius_to, int sides, Tag tag);

/// A closed surface around `center` whose radius varies at random by the share `roughness`.
void addLumpyEllipsoid(TriangleMesh& mesh, const Eigen::Vector3d& center,
                       const Eigen::Vector3d& radii, double roughness, Random& random, Tag tag);

/// A spinning LiDAR. Its frame: x forward, y left, z up.
struct LidarModel {
  int rings = 64;
  int azimuths = 1024;
  double lowest_deg = -24.8, highest_deg = 2;  ///< elevation of the outermost beams
  double max_range_m = 80;                     ///< no return from further away
};

template <class Visitor>
void visit(LidarModel& o, Visitor&& field) {
  field("rings", o.rings, Range{1, 512}, "laser beams above one another");
  field("azimuths", o.azimuths, Range{8, 8192}, "measurements per turn");
}

/// Triangles, ready to be met by rays.
class RayScene {
 public:
  explicit RayScene(TriangleMesh mesh);

 private:
  friend class RayCaster;
  TriangleMesh mesh_;
  std::shared_ptr<RTCSceneTy> tree_;
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
