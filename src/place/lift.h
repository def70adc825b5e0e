// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "xview/base/frame.h"
#include "xview/options.h"
#include "xview/place_builder.h"

namespace xview {

/// How far a sensor is believed, as share of LiftOptions::max_range_m. A camera is in the air if
/// the nearest tenth of a frame is more than 15 m away: it looks down, so that walls are rare and
/// errors of depth mostly of height. The error of a LiDAR hardly grows with the range, but its
/// points thin out.
constexpr double kRangeFromTheAir = 2.4, kRangeOfLidar = 1.2;

/// The range limit of a frame's sensor: cameras near the ground, cameras in the air, LiDAR;
/// infinite for saved clouds.
double maxRange(const Frame& frame, const LiftOptions& options);

/// Labelled points of one frame in the odometry frame: p_odom = T_odom_sensor * p_sensor, with
/// p_sensor = z * K^-1 [u v 1] for planar depth. Every measurement is lifted or counted once,
/// asking for its class, then its depth, then its range (distance to the sensor). Saved clouds
/// (Sensor::cloud) have no range limits.
///
/// `origin` of the result is the sensor position rounded to 1 m (saved clouds: their own origin,
/// moved along). Throws Error if images differ in size, focal lengths are not positive or the pose
/// is not finite.
LabelledCloud lift(const Frame& frame, const LabelSet& set, const LiftOptions& options,
                   LiftCounts* counts = nullptr);

/// One point per voxel, class and instance: their centroid, in order of first appearance, of large
/// clouds square by square of 128 voxels; sigmas are averaged. Voxels are cells of the frame of the
/// cloud, whatever its origin. Points that are not finite, or 2^30 voxels from zero, are left out;
/// voxel_m = 0 changes nothing. `points_per_voxel`, if given, receives how many points each one
/// stands for.
LabelledCloud thinByVoxel(const LabelledCloud& cloud, double voxel_m,
                          std::vector<std::uint32_t>* points_per_voxel = nullptr);

/// Which points of a frame are wanted besides the thinned ones.
enum class WholeClasses { none, no_surfaces, all };

/// A frame as mapping needs it.
struct ThinFrame {
  LabelledCloud thin;  ///< all points, thinned by voxel
  std::vector<std::uint32_t> points_per_voxel;
  LabelledCloud whole;     ///< the points of the classes that were asked for, as they are
  bool is_aerial = false;  ///< a camera, and the nearest tenth of its points is over 15 m away
};

/// thinByVoxel(lift(frame), voxel_m) in one go, without all points in memory: the same results.
ThinFrame liftThin(const Frame& frame, const LabelSet& set, const LiftOptions& options,
                   double voxel_m, WholeClasses whole, LiftCounts* counts = nullptr);

}  // namespace xview
