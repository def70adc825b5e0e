// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "base/cells.h"
#include "xview/base/semantic_place.h"

namespace xview {

/// How far one sees from the poses of a place, by its own cloud: of each pose a panorama of the
/// nearest and the farthest point in each direction. A point stands for a voxel of a thinned cloud,
/// so that rays do not pass between those of a surface nearby.
class Sight {
 public:
  enum class Ray {
    open,     ///< no pose is near enough, or nothing is known in that direction
    blocked,  ///< something is before the point, or the last thing seen is no farther
    passes    ///< from one of the poses it is free up to the point, and something is seen behind it
  };

  /// Of the poses in `near` [m]; frame of the place.
  Sight(const Place& place, const Eigen::AlignedBox3d& near);

  /// To a point in the frame of the place; things are told apart if `margin_m` lies between them.
  Ray to(const Eigen::Vector3d& p, double margin_m) const;

 private:
  struct Ranges {
    std::uint16_t nearest_cm = 0xFFFF, farthest_cm = 0;  ///< 0 = nothing is known
  };
  struct Panorama {
    Eigen::Vector3d from;
    std::vector<Ranges> ranges;  ///< by elevation, then azimuth
  };
  std::vector<Panorama> panoramas_;
  CellLists standpoints_;  ///< numbers of panoramas
};

}  // namespace xview
