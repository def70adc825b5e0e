// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <functional>
#include <limits>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "xview/base/labelled_cloud.h"

namespace xview {

// Points that belong to no place: a driver writes one for every pulse that does not come back, or
// lets a wrong number through. They are left out where a cloud is taken in, and where something is
// measured of a cloud it is measured of where most of its points lie.

/// Position of a point by its number.
using PositionAt = std::function<Eigen::Vector3d(std::size_t)>;

/// The box of the points, without those that lie farther outside of the middle nine tenths than
/// three times the reach of these. Of an honest cloud that is its box.
Eigen::AlignedBox3d boxWithoutStrays(std::size_t count, const PositionAt& position);
Eigen::AlignedBox3d boxWithoutStrays(const LabelledCloud& cloud);

/// Leaves out of a cloud, and counts in `left_out`, what is not finite, what repeats one position
/// more often than by chance, and what is so far from the middle that it can be of no place with
/// the rest. `name`: of the cloud, for messages. Throws Error if that were most of the points.
void leaveOutStrays(const std::string& name, LabelledCloud& cloud);

/// What was left out of the frames of a recording, which several threads may read, some twice.
class LeftOutOfFrames {
 public:
  void set(std::size_t frame, const LeftOut& left_out);
  LeftOut sum() const;

 private:
  mutable std::mutex mutex_;
  std::map<std::size_t, LeftOut> of_frames_;  ///< with strays
};

/// Collects points that arrive in double precision, and leaves out strays as above. The first
/// coordinate beyond `far_m` makes that point, rounded down to metres, the origin of the cloud.
class CloudBuilder {
 public:
  explicit CloudBuilder(double far_m = std::numeric_limits<double>::infinity()) : far_m_(far_m) {}

  void reserve(std::size_t points) { cloud_.points.reserve(points); }
  /// The point has everything but its position, which is finite.
  void add(const Eigen::Vector3d& position, Point point);
  LabelledCloud finish(const std::string& name);

 private:
  /// What would lose its millimetres beside the origin that the cloud has so far.
  struct FarPoint {
    std::size_t number;
    Eigen::Vector3d position;
  };

  void keepIfFar(std::size_t number, const Eigen::Vector3d& position);
  void setOrigin(const Eigen::Vector3d& position);
  Eigen::Vector3d position(std::size_t i) const;

  double far_m_;
  bool has_origin_ = false;
  LabelledCloud cloud_;
  std::vector<FarPoint> far_points_;  ///< by number
};

}  // namespace xview
