// SPDX-License-Identifier: BSD-3-Clause
#include "xview/sim/mesh.h"

#include <cmath>

namespace xview {
namespace {

constexpr int kEllipsoidRings = 5;
constexpr int kEllipsoidSides = 9;

std::uint32_t addVertex(TriangleMesh& mesh, const Eigen::Vector3d& p) {
  mesh.vertices.push_back(p.cast<float>());
  return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
}

void addIndexed(TriangleMesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c, Tag tag) {
  mesh.triangles.push_back({{a, b, c}, tag});
}

/// Two unit vectors that complete `axis` to an orthogonal frame.
std::pair<Eigen::Vector3d, Eigen::Vector3d> crossSection(const Eigen::Vector3d& axis) {
  const Eigen::Vector3d u = axis.unitOrthogonal();
  return {u, axis.cross(u)};
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
            Tag tag) {
  addTaperedBox(mesh, T_world_box, size, Eigen::Vector2d::Ones(), tag);
}

void addTaperedBox(TriangleMesh& mesh, const Eigen::Isometry3d& T_world_box,
                   const Eigen::Vector3d& size, const Eigen::Vector2d& taper, Tag tag) {
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
  const auto [u, v] = crossSection((to - from).normalized());
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

void append(TriangleMesh& mesh, const TriangleMesh& part) {
  const auto offset = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), part.vertices.begin(), part.vertices.end());
  mesh.triangles.reserve(mesh.triangles.size() + part.triangles.size());
  for (TriangleMesh::Triangle triangle : part.triangles) {
    for (std::uint32_t& corner : triangle.corner) corner += offset;
    mesh.triangles.push_back(triangle);
  }
}

}  // namespace xview
