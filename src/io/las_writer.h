// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <functional>
#include <string>

namespace xview::io {

/// User and number of the variable record that names classes.
constexpr const char* kLasUser = "xview";
constexpr std::uint16_t kLasClasses = 1;

/// What a record of LAS point format 7 holds.
struct LasPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< [m]
  std::uint32_t label = 0;                             ///< 0 to 255
  std::uint16_t intensity = 0, source = 0;
  std::uint8_t return_number = 1, returns = 1;
  double gps_time = 0;
  std::array<std::uint16_t, 3> color{};  ///< red, green, blue
};
/// Calls visit for all points, in their order, as often as it is called.
using LasPoints = std::function<void(const std::function<void(const LasPoint&)>& visit)>;

/// LAS 1.4 with coordinates in millimetres from the middle, rounded down to metres. What is not
/// finite is left out. `classes`: lines that name them (classComments), kept in a record of
/// their own. Throws Error, also for labels above 255 and for points that are too far apart.
void writeLas(const std::string& path, const LasPoints& points, const std::string& classes);

/// A LAS file again, moved: all its fields and records are as they were, and coordinates as fine
/// as the finest of them was. Throws Error.
void copyLas(const std::string& from, const std::string& to, const Eigen::Affine3d& moved);

}  // namespace xview::io
