// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <map>
#include <utility>
#include <vector>

#include "xview/base/semantic_place.h"

namespace xview {

/// From one storey to the next, at least, in metres of the world.
constexpr double kLowestStorey_m = 1.8;

/// A layer of a place: heights from `bottom` up to `top`, upright, in its lengths.
struct Storey {
  double bottom = 0, top = 0;
  bool holds(double z) const { return bottom <= z && z < top; }
};

/// How often each height occurs, by bin.
class HeightCounts {
 public:
  explicit HeightCounts(double bin) : bin_(bin) {}
  void add(double z);
  std::size_t size() const { return size_; }
  /// Heights around which most are first, with their numbers; of equal ones the lowest.
  std::vector<std::pair<int, double>> ranked() const;
  /// Where fewest are between two heights; of equal ones the highest.
  double emptiest(double low, double high) const;

 private:
  int at(long bin) const;

  double bin_;
  std::map<long, int> counts_;
  std::size_t size_ = 0;
};

/// Finds the storeys of a place of rooms: heights at which many of its poses are, each with a
/// floor, where a good part of them lie above one another. All else is one plane, and so is all of
/// a town, where an odometry that drifts puts a street above itself.
class StoreyFinder {
 public:
  /// `poses`: T_place_sensor. `upright`: turns the frame of the place so that z is up. `size`:
  /// its lengths are metres over that (canonical ones, see kTownScale).
  StoreyFinder(const std::vector<Eigen::Isometry3d>& poses, const Eigen::Quaterniond& upright,
               double size);

  bool isOnePlane() const { return levels_.size() < 2; }
  /// Points tell the heights of floors.
  void add(const LabelledCloud& cloud, const LabelSet& labels);
  /// From below, without gaps; none of one plane.
  std::vector<Storey> storeys() const;

 private:
  Eigen::Quaterniond upright_;
  double per_metre_;
  std::vector<double> levels_;  ///< heights of sensors
  std::vector<HeightCounts> floors_;
  HeightCounts points_;
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
