// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "xview/sim/ground.h"
#include "xview/sim/mesh.h"
#include "xview/sim/streets.h"

namespace xview {

/// A rectangle in plan view.
struct Footprint {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  double yaw = 0;
  Eigen::Vector2d size = Eigen::Vector2d::Ones();

  Eigen::Vector2d toWorld(const Eigen::Vector2d& p) const;
  double distanceTo(const Eigen::Vector2d& p) const;  ///< 0 inside [m]
};

/// True if two rectangles, the first grown by `gap_m` on all sides, have a point in common.
bool overlap(const Footprint& a, const Footprint& b, double gap_m);

/// Gives every object an instance of its own. There are 65535; a town of more objects uses them
/// again.
class TagSource {
 public:
  explicit TagSource(std::uint16_t last = 0) : last_(last) {}
  Tag next(std::uint16_t label) {
    last_ = last_ == 65535 ? 1 : static_cast<std::uint16_t>(last_ + 1);
    return {label, last_};
  }
  std::uint16_t last() const { return last_; }

 private:
  std::uint16_t last_;
};

/// A building site: what stands already, and where there is room.
struct Site {
  Site(const StreetNetwork& network, std::uint64_t seed, double relief_m)
      : field(network), relief(seed, relief_m) {}

  StreetField field;
  Relief relief;
  TriangleMesh mesh;
  std::vector<Footprint> houses;
  TagSource tags;

  Eigen::Vector3d onGround(const Eigen::Vector2d& p) const;
  /// Away from sidewalks, roads and houses by these distances.
  bool isFree(const Eigen::Vector2d& p, double from_sidewalk_m, double from_house_m) const;
  bool hasRoomFor(const Footprint& house) const;
};

}  // namespace xview
