// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace xview {

using Color = std::array<std::uint8_t, 3>;  ///< red, green, blue

/// A coloured triangle mesh: what every viewer shows alike, unlike lines and big points.
struct ColorMesh {
  std::vector<Eigen::Vector3d> vertices;  ///< [m]
  std::vector<Color> colors;              ///< one per vertex
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// Eight triangles around a point.
void addOctahedron(ColorMesh& mesh, const Eigen::Vector3d& center, double radius_m,
                   const Color& color);

/// A tube with three sides, open at its ends. Nothing if both ends are the same point.
void addTube(ColorMesh& mesh, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
             double radius_m, const Color& color);

/// Legacy ASCII VTK: POLYGONS with COLOR_SCALARS, for `pcl_viewer cloud.pcd mesh.vtk`. Coordinates
/// in millimetres' precision.
std::string toVtk(const ColorMesh& mesh);

/// ASCII PLY mesh with red green blue per vertex, for MeshLab, CloudCompare and the like.
std::string toPly(const ColorMesh& mesh);

}  // namespace xview
