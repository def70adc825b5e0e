// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "xview/base/semantic_place.h"

namespace xview {

/// A landmark that is not as it was.
struct Change {
  enum class What { gone, added, moved };
  What what = What::gone;
  std::uint32_t label = 0;                             ///< its class, of the earlier visit's set
  bool is_dynamic = false;                             ///< of a class that moves anyway: cars
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< of what is new, else as it was [m]
  Eigen::Vector3d extent = Eigen::Vector3d::Zero();    ///< size of its box [m]
  double sigma_m = 0;      ///< of its position, and of the pose between the visits [m]
  double probability = 0;  ///< that this changed, in (0, 1)
  std::optional<Eigen::Vector3d> moved_to;  ///< where it stands now [m]
};

const char* toString(Change::What what);  ///< "gone", "new", "moved"

/// What the later visit says of a vertex of the earlier one.
enum class Presence {
  unknown,  ///< it did not look there, or a vertex of a surface
  stands,
  gone
};

struct Changes {
  std::vector<Change> changes;     ///< by what happened, the surest first
  std::vector<Presence> presence;  ///< one per vertex of the earlier visit
  std::size_t compared = 0;        ///< landmarks of static classes that both visits observed
  bool has_looked = true;          ///< false: one of them does not tell where it has looked
};

/// What appeared, disappeared or moved between two visits, in the frame of the earlier one. The
/// later one must have its classes; `T_earlier_later` brings its frame there and is known to
/// `sigma_m`.
///
/// A landmark is a vertex of an object or dynamic class whose points are known. Unless it is a
/// post, it has 30 % of the observations that are usual around it; with fewer it is noise of the
/// labels or has stood for a part of the visit, and `presence` alone tells of it. Each of its
/// points is asked of the other visit, which met it there (a point as near, of its class or of
/// another one), sees through it (from a key frame the ray is free up to the point, and ends behind
/// it; where nothing is known in that direction, ground measured all around the foot says the
/// same), or does not tell. It was looked at if enough points tell and what stands around it is met
/// again, so that neither what is hidden nor what is displaced by drift counts; of other places
/// nothing is said. If more than half of its points are met it stands, but for another class. Else
/// the share of points of an unchanged landmark that are met follows from the landmarks that both
/// have, the share that is met under the null hypothesis from places beside them, and the
/// probability from both; where all that is met is of another class, it follows from the noise of
/// the labels, and is 0 for classes that were taken from shapes. New is what is gone with the
/// visits exchanged. Parts that touch are one thing, and of its classes those are noise that have a
/// smaller share of the measurements there than labels are noisy. A gone landmark and the nearest
/// new one of its class within some metres have moved. Surfaces are not compared, but where classes
/// were taken from shapes, which call a box a wall: there what stands where the other visit met
/// nothing is a landmark, if it is no longer than 8 m.
Changes findChanges(const Place& earlier, const Place& later,
                    const Eigen::Isometry3d& T_earlier_later, double sigma_m);

/// Takes landmarks out of a place: vertices, the points of their class where they stood, and
/// samples of the BEV grid under which no obstacle is left.
void removeObjects(Place& place, const std::vector<std::size_t>& vertices);

}  // namespace xview
