// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

#include "xview/types/random.h"

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

/// A box that stands on z = 0 of its own frame, centred in x and y.
void addBox(TriangleMesh& mesh, const Eigen::Isometry3d& T_world_box, const Eigen::Vector3d& size,
            Tag tag);

/// A box whose top is scaled about its axis by `taper` in x and y: car cabins, hipped roofs.
void addTaperedBox(TriangleMesh& mesh, const Eigen::Isometry3d& T_world_box,
                   const Eigen::Vector3d& size, const Eigen::Vector2d& taper, Tag tag);

/// A (cut) cone or cylinder with closed ends from `from` to `to`.
void addTube(TriangleMesh& mesh, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
             double radius_from, double radius_to, int sides, Tag tag);

/// A closed surface around `center` whose radius varies at random by the share `roughness`.
void addLumpyEllipsoid(TriangleMesh& mesh, const Eigen::Vector3d& center,
                       const Eigen::Vector3d& radii, double roughness, Random& random, Tag tag);

/// Appends all of `part`.
void append(TriangleMesh& mesh, const TriangleMesh& part);

}  // namespace xview
