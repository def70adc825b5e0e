// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "base/random.h"
#include "xview/base/bev_grid.h"

namespace xview::test {

/// A made-up town in BEV grid, from which views are drawn in any frame.
class BevTown {
 public:
  void line(BevChannel channel, double x0, double y0, double x1, double y1);
  void area(BevChannel channel, double x0, double y0, double x1, double y1);
  void object(BevChannel channel, double x, double y);
  /// The outline of a house: walls with their feet.
  void house(double x0, double y0, double x1, double y1);
  /// A street along x with pavements, houses, fences, trees and poles at random.
  void street(double x0, double x1, double y, Random& random);
  /// Another copy of everything so far.
  void repeat(double dx, double dy);
  BevTown mirrored() const;

  /// What lies within `radius` of a place, drawn on the cells of a frame. Heights are
  /// groundHeight() + T.z.
  BevGrid view(const Eigen::Vector2d& place, double radius_m, const Eigen::Isometry3d& T_frame_town,
               double origin_x = 0, double origin_y = 0) const;
  static double groundHeight(double x, double y) { return 0.02 * x - 0.01 * y; }

 private:
  std::array<std::vector<Eigen::Vector2d>, kBevChannels> points_;
};

/// Three unlike parallel streets of 240 m.
BevTown randomTown(std::uint64_t seed);
/// Sensor positions along those streets.
std::vector<Eigen::Vector3d> driveThrough();

}  // namespace xview::test
