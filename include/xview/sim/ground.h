// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "xview/sim/mesh.h"
#include "xview/sim/streets.h"

namespace xview {

/// Gentle hills: a sum of waves of 150 to 500 m length, evaluated on a triangulated grid of kCell,
/// so that finer triangulations of the same ground lie in the same planes.
class Relief {
 public:
  static constexpr double kCell = 4;  ///< [m]

  Relief(std::uint64_t seed, double amplitude_m);
  double at(const Eigen::Vector2d& p) const;  ///< height of sidewalks and gardens [m]

 private:
  struct Wave {
    Eigen::Vector2d number;  ///< [rad/m]
    double phase, amplitude_m;
  };
  double smooth(const Eigen::Vector2d& p) const;
  std::array<Wave, 5> waves_;
};

constexpr double kCurb = 0.12;  ///< roads lie lower than sidewalks by this [m]

/// Height of what one stands on: the relief, less the curb on a road.
double groundHeight(const Relief& relief, const StreetField& field, const Eigen::Vector2d& p);

/// Road, sidewalk, terrain and curbs up to `margin_m` beyond the streets, cut along the edges of
/// the field.
void addGround(TriangleMesh& mesh, const Relief& relief, const StreetField& field, double margin_m);

/// Dashed and solid lines along the streets and zebra crossings, just above the road.
void addLaneMarkings(TriangleMesh& mesh, const StreetNetwork& network, const Relief& relief,
                     const StreetField& field, std::uint64_t seed);

}  // namespace xview
