// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "place/floors.h"
#include "xview/base/semantic_place.h"

namespace xview {

/// A layer of a place: heights from `bottom` up to `top`, upright, in its lengths.
struct Storey {
  double bottom = 0, top = 0;
  bool holds(double z) const { return bottom <= z && z < top; }
};

/// Finds the storeys of a place of rooms. Where a good part of its poses lie above one another:
/// heights at which many of them are, each with a floor. Else, as of a cloud: floors that lie above
/// one another. All else is one plane, and so is all of a town, where an odometry that drifts puts
/// a street above itself.
class StoreyFinder {
 public:
  /// `poses`: T_place_sensor. `upright`: turns the frame of the place so that z is up. `size`:
  /// its lengths are metres over that (canonical ones, see kTownScale).
  StoreyFinder(const std::vector<Eigen::Isometry3d>& poses, const Eigen::Quaterniond& upright,
               double size);

  /// Points tell the heights of floors.
  void add(const LabelledCloud& cloud, const LabelSet& labels);
  /// From below, without gaps; none of one plane.
  std::vector<Storey> storeys() const;

 private:
  std::vector<double> floorsBelowPoses() const;

  Eigen::Quaterniond upright_;
  double per_metre_;
  bool is_town_;
  std::vector<double> levels_;  ///< heights of sensors
  std::vector<HeightCounts> floors_;
  HeightCounts points_;
  FloorFinder surfaces_;
};

/// Whether poses in metres stand above one another as on the floors of a building.
bool standOnSeveralFloors(const std::vector<Eigen::Isometry3d>& poses,
                          const Eigen::Quaterniond& upright);

/// The points of a place between two heights.
LabelledCloud pointsIn(const Storey& storey, const LabelledCloud& cloud,
                       const Eigen::Quaterniond& upright);

/// A storey of a place with its view, drawn of its points.
struct StoreyOfPlace {
  Storey heights;
  BevGrid view;
};
/// The storeys of a place that was not seen from the air; none if it is one plane.
std::vector<StoreyOfPlace> storeysOf(const Place& place);
/// placeThinObjects() and dropContradicted() of each storey with its own view.
void placeThinObjects(const std::vector<StoreyOfPlace>& storeys, Place& place);
void dropContradicted(const std::vector<StoreyOfPlace>& storeys, Place& place);

/// The bird's-eye view of a thinned cloud of labelled points, which has one point of each class in
/// a voxel: classes count as much as they prevail around.
BevGrid viewOfThinned(const LabelledCloud& cloud, const LabelSet& labels,
                      const Eigen::Quaterniond& upright);

}  // namespace xview
