// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "process/module.h"
#include "sim/embree_ray_tree.h"
#include "sim/town.h"
#include "xview/base/error.h"

namespace xview {
namespace {

constexpr int kPacket = 8;        // rays that are traced at once
constexpr float kFarthest = 650;  // what a 16-bit image in centimetres can hold; beyond is sky [m]
constexpr int kEllipsoidRings = 5;
constexpr int kEllipsoidSides = 9;

std::uint32_t addVertex(TriangleMesh& mesh, const Eigen::Vector3d& p) {
  mesh.vertices.push_back(p.cast<float>());
  return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
}

void addIndexed(TriangleMesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c, Tag tag) {
  mesh.triangles.push_back({{a, b, c}, tag});
}

/// The functions of the module xview_ray_casting.
struct RayCasting {
  decltype(&xviewMakeRayTree) makeTree = function<decltype(makeTree)>("xviewMakeRayTree");
  decltype(&xviewReleaseRayTree) release = function<decltype(release)>("xviewReleaseRayTree");
  decltype(&xviewCastRays) cast = function<decltype(cast)>("xviewCastRays");

 private:
  template <class Function>
  static Function function(const char* name) {
    return reinterpret_cast<Function>(
        moduleFunction("xview_ray_casting", name, "simulated worlds"));
  }
};
const RayCasting& rayCasting() {
  static const RayCasting functions;
  return functions;
}

}  // namespace

void addTriangle(TriangleMesh& mesh, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                 const Eigen::Vector3d& c, Tag tag) {
  const std::uint32_t first = addVertex(mesh, a);
  addVertex(mesh, b);
  addVertex(mesh, c);
  addIndexed(mesh, first, first + 1, first + 2, tag);
}

void addQuad(TriangleMesh& mesh, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
             const Eigen::Vector3d& c, const Eigen::Vector3d& d, Tag tag) {
  const std::uint32_t first = addVertex(mesh, a);
  addVertex(mesh, b);
  addVertex(mesh, c);
  addVertex(mesh, d);
  addIndexed(mesh, first, first + 1, first + 2, tag);
  addIndexed(mesh, first, first + 2, first + 3, tag);
}

void addBox(TriangleMesh& mesh, const Eigen::Isometry3d& T_world_box, const Eigen::Vector3d& size,
            Tag tag, const Eigen::Vector2d& taper) {
  Eigen::Vector3d corner[8];
  for (int i = 0; i < 8; ++i) {
    const bool top = i >= 4;
    const double x = (i % 4 == 1 || i % 4 == 2 ? 0.5 : -0.5) * size.x() * (top ? taper.x() : 1);
    const double y = (i % 4 >= 2 ? 0.5 : -0.5) * size.y() * (top ? taper.y() : 1);
    corner[i] = T_world_box * Eigen::Vector3d(x, y, top ? size.z() : 0);
  }
  addQuad(mesh, corner[0], corner[3], corner[2], corner[1], tag);
  addQuad(mesh, corner[4], corner[5], corner[6], corner[7], tag);
  for (int i = 0; i < 4; ++i) {
    const int j = (i + 1) % 4;
    addQuad(mesh, corner[i], corner[j], corner[j + 4], corner[i + 4], tag);
  }
}

void addTube(TriangleMesh& mesh, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
             double radius_from, double radius_to, int sides, Tag tag) {
  const Eigen::Vector3d axis = (to - from).normalized();
  const Eigen::Vector3d u = axis.unitOrthogonal(), v = axis.cross(u);
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (int i = 0; i < sides; ++i) {
    const double angle = 2 * M_PI * i / sides;
    const Eigen::Vector3d direction = std::cos(angle) * u + std::sin(angle) * v;
    addVertex(mesh, from + radius_from * direction);
    addVertex(mesh, to + radius_to * direction);
  }
  const std::uint32_t bottom = addVertex(mesh, from), top = addVertex(mesh, to);
  for (int i = 0; i < sides; ++i) {
    const std::uint32_t a = first + 2 * i, b = first + 2 * ((i + 1) % sides);
    addIndexed(mesh, a, b, b + 1, tag);
    addIndexed(mesh, a, b + 1, a + 1, tag);
    addIndexed(mesh, bottom, b, a, tag);
    addIndexed(mesh, top, a + 1, b + 1, tag);
  }
}

void addLumpyEllipsoid(TriangleMesh& mesh, const Eigen::Vector3d& center,
                       const Eigen::Vector3d& radii, double roughness, Random& random, Tag tag) {
  const auto point = [&](double elevation, double azimuth) {
    const Eigen::Vector3d direction(std::cos(elevation) * std::cos(azimuth),
                                    std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
    return Eigen::Vector3d(center +
                           radii.cwiseProduct(direction) * (1 + roughness * random.uniform(-1, 1)));
  };
  const std::uint32_t bottom = addVertex(mesh, point(-M_PI / 2, 0));
  const std::uint32_t top = addVertex(mesh, point(M_PI / 2, 0));
  const std::uint32_t first = top + 1;
  for (int ring = 0; ring < kEllipsoidRings; ++ring) {
    const double elevation = M_PI * ((ring + 1.0) / (kEllipsoidRings + 1) - 0.5);
    for (int side = 0; side < kEllipsoidSides; ++side) {
      addVertex(mesh, point(elevation, 2 * M_PI * (side + 0.5 * ring) / kEllipsoidSides));
    }
  }
  for (int side = 0; side < kEllipsoidSides; ++side) {
    const std::uint32_t next = (side + 1) % kEllipsoidSides;
    addIndexed(mesh, bottom, first + next, first + side, tag);
    for (int ring = 0; ring + 1 < kEllipsoidRings; ++ring) {
      const std::uint32_t low = first + ring * kEllipsoidSides, high = low + kEllipsoidSides;
      addIndexed(mesh, low + side, low + next, high + side, tag);
      addIndexed(mesh, high + side, low + next, high + next, tag);
    }
    const std::uint32_t last = first + (kEllipsoidRings - 1) * kEllipsoidSides;
    addIndexed(mesh, top, last + side, last + next, tag);
  }
}

RayScene::RayScene(TriangleMesh mesh)
    : mesh_(std::move(mesh)), tree_(rayCasting().makeTree(mesh_), rayCasting().release) {
  if (!tree_) throw Error("Embree", "no ray-tracing device on this machine");
}

/// Where rays from one point first meet a scene.
class RayCaster {
 public:
  struct Hit {
    double distance = 0;  ///< in units of the ray's direction; 0 = nothing met
    Tag tag;
  };

  RayCaster(const std::vector<std::shared_ptr<const RayScene>>& scenes,
            const Eigen::Vector3d& origin)
      : scenes_(scenes), origin_(origin) {}

  /// Up to kPacket rays at once.
  void cast(const Eigen::Vector3d* directions, int count, Hit* hits) const {
    alignas(32) int valid[kPacket];
    RTCRayHit8 packet;
    const Eigen::Vector3f o = origin_.cast<float>();
    for (int i = 0; i < kPacket; ++i) {
      valid[i] = i < count ? -1 : 0;
      const Eigen::Vector3f d = directions[std::min(i, count - 1)].cast<float>();
      packet.ray.org_x[i] = o.x();
      packet.ray.org_y[i] = o.y();
      packet.ray.org_z[i] = o.z();
      packet.ray.dir_x[i] = d.x();
      packet.ray.dir_y[i] = d.y();
      packet.ray.dir_z[i] = d.z();
      packet.ray.tnear[i] = 0;
      packet.ray.tfar[i] = kFarthest;
      packet.ray.time[i] = 0;
      packet.ray.mask[i] = ~0u;
      packet.ray.id[i] = static_cast<unsigned>(i);
      packet.ray.flags[i] = 0;
      if (i < count) hits[i] = Hit();
    }
    for (const auto& scene : scenes_) castInto(*scene, valid, packet, directions, count, hits);
  }

 private:
  /// Shortens the rays that meet something nearer than before.
  void castInto(const RayScene& scene, const int* valid, RTCRayHit8& packet,
                const Eigen::Vector3d* directions, int count, Hit* hits) const {
    std::fill(packet.hit.geomID, packet.hit.geomID + kPacket, RTC_INVALID_GEOMETRY_ID);
    std::fill(packet.hit.instID[0], packet.hit.instID[0] + kPacket, RTC_INVALID_GEOMETRY_ID);
    rayCasting().cast(valid, scene.tree_.get(), packet);
    for (int i = 0; i < count; ++i) {
      if (packet.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
      const TriangleMesh::Triangle& triangle = scene.mesh_.triangles[packet.hit.primID[i]];
      hits[i] = {distanceToPlane(scene.mesh_, triangle, directions[i], packet.ray.tfar[i]),
                 triangle.tag};
    }
  }

  /// The tracer finds the triangle in single precision; the distance is computed again, so that it
  /// does not depend on the instruction set that the tracer chose.
  double distanceToPlane(const TriangleMesh& mesh, const TriangleMesh::Triangle& triangle,
                         const Eigen::Vector3d& direction, double found) const {
    const Eigen::Vector3d a = mesh.vertices[triangle.corner[0]].cast<double>();
    const Eigen::Vector3d b = mesh.vertices[triangle.corner[1]].cast<double>();
    const Eigen::Vector3d c = mesh.vertices[triangle.corner[2]].cast<double>();
    const Eigen::Vector3d normal = (b - a).cross(c - a);
    const double slope = normal.dot(direction);
    const double distance = normal.dot(a - origin_) / slope;
    const bool grazing = !(std::abs(distance - found) < 0.02 * found + 0.02);
    return grazing ? found : distance;
  }

  const std::vector<std::shared_ptr<const RayScene>>& scenes_;
  Eigen::Vector3d origin_;
};

Renderer::Renderer(std::vector<std::shared_ptr<const RayScene>> scenes)
    : scenes_(std::move(scenes)) {}

Frame Renderer::renderCamera(const Camera& camera, const Eigen::Isometry3d& T_world_camera,
                             int threads) const {
  Frame frame;
  frame.sensor = Sensor::camera;
  frame.camera = camera;
  frame.camera.depth_is_range = false;
  frame.depth = DepthImage(camera.width, camera.height);
  frame.label = LabelImage(camera.width, camera.height, town_class::kSky);
  frame.instance = LabelImage(camera.width, camera.height);
  const RayCaster caster(scenes_, T_world_camera.translation());
  const Eigen::Matrix3d R = T_world_camera.linear();
  parallelFor(static_cast<std::size_t>(camera.height), threads, [&](std::size_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < camera.width; x += kPacket) {
      const int count = std::min(kPacket, camera.width - x);
      Eigen::Vector3d directions[kPacket];
      RayCaster::Hit hits[kPacket];
      for (int i = 0; i < count; ++i) {
        // Not normalised: a step of 1 along the ray is 1 m of planar depth.
        directions[i] =
            R * Eigen::Vector3d((x + i - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1);
      }
      caster.cast(directions, count, hits);
      for (int i = 0; i < count; ++i) {
        if (hits[i].distance <= 0) continue;
        frame.depth.at(x + i, y) = static_cast<float>(hits[i].distance);
        frame.label.at(x + i, y) = hits[i].tag.label;
        frame.instance.at(x + i, y) = hits[i].tag.instance;
      }
    }
  });
  return frame;
}

Frame Renderer::renderLidar(const LidarModel& lidar, const Eigen::Isometry3d& T_world_lidar,
                            int threads) const {
  const RayCaster caster(scenes_, T_world_lidar.translation());
  const Eigen::Matrix3d R = T_world_lidar.linear();
  const auto direction = [&](int ring, int azimuth) {
    const double share = lidar.rings > 1 ? static_cast<double>(ring) / (lidar.rings - 1) : 0;
    const double elevation =
        (lidar.lowest_deg + share * (lidar.highest_deg - lidar.lowest_deg)) * M_PI / 180;
    const double yaw = 2 * M_PI * azimuth / lidar.azimuths;
    return Eigen::Vector3d(std::cos(elevation) * std::cos(yaw), std::cos(elevation) * std::sin(yaw),
                           std::sin(elevation));
  };
  std::vector<std::vector<RayCaster::Hit>> rings(
      static_cast<std::size_t>(lidar.rings),
      std::vector<RayCaster::Hit>(static_cast<std::size_t>(lidar.azimuths)));
  parallelFor(rings.size(), threads, [&](std::size_t ring) {
    for (int a = 0; a < lidar.azimuths; a += kPacket) {
      const int count = std::min(kPacket, lidar.azimuths - a);
      Eigen::Vector3d directions[kPacket];
      for (int i = 0; i < count; ++i) directions[i] = R * direction(static_cast<int>(ring), a + i);
      caster.cast(directions, count, &rings[ring][static_cast<std::size_t>(a)]);
    }
  });

  Frame frame;
  frame.sensor = Sensor::lidar;
  for (int ring = 0; ring < lidar.rings; ++ring) {
    for (int a = 0; a < lidar.azimuths; ++a) {
      const RayCaster::Hit& hit =
          rings[static_cast<std::size_t>(ring)][static_cast<std::size_t>(a)];
      if (hit.distance <= 0 || hit.distance > lidar.max_range_m) continue;
      Point point;
      point.getVector3fMap() = (hit.distance * direction(ring, a)).cast<float>();
      point.label = hit.tag.label;
      point.instance = hit.tag.instance;
      frame.cloud.points.push_back(point);
    }
  }
  return frame;
}

Camera pinholeCamera(int width, int height, double horizontal_view_rad) {
  const double focal = width / (2 * std::tan(horizontal_view_rad / 2));
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = focal;
  camera.cx = (width - 1) / 2.0;
  camera.cy = (height - 1) / 2.0;
  return camera;
}

}  // namespace xview
