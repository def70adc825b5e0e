// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "xview/sim/recordings.h"

namespace xview {

/// A world as the first drive and as all later ones see it.
struct TwoVisits {
  TriangleMesh before, after;
  std::vector<ThingChange> changes;
};

/// Where a thing could stand instead, on the ground near a point of it; none if there is no room.
using PlaceNear = std::function<std::optional<Eigen::Vector3d>(const Eigen::Vector3d&, Random&)>;

/// Takes away, adds and moves a share of the things of object classes, a third each; a thing with
/// all of its parts, which are of one instance. Things that are added stand where the world has
/// them, and are missing before.
TwoVisits withChanges(TriangleMesh world, const LabelSet& labels, double share, std::uint64_t seed,
                      const PlaceNear& placeNear);

}  // namespace xview
