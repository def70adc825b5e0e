// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "xview/graph/lift.h"

namespace xview::graph {

// Points as columns, row by row of an image or in pieces of a cloud, so that several are worked on
// at once and a frame is never held as points.

struct PointRow {
  explicit PointRow(std::size_t capacity)
      : x(capacity),
        y(capacity),
        z(capacity),
        range(capacity),
        sigma(capacity),
        label(capacity),
        instance(capacity) {}

  Point point(std::size_t i) const {
    Point point(x[i], y[i], z[i], label[i]);
    point.instance = instance[i];
    point.sigma = sigma[i];
    return point;
  }

  std::size_t size = 0;  ///< points in use
  std::vector<float> x, y, z;
  std::vector<float> range;  ///< to the sensor [m], 0 if it is not known
  std::vector<float> sigma;  ///< of the position [m]
  std::vector<std::uint32_t> label, instance;
};

constexpr std::size_t kPointsAtOnce = 512;  ///< of a cloud; they stay in the first cache

/// A camera whose nearest tenth is farther away than this looks down from the air.
constexpr float kAerialQuantile_m = 15;

/// What is known of a frame before its points are looked at.
struct LiftPlan {
  float min_range2, max_range2;  ///< smallest and largest distance that is believed, squared
  Eigen::Vector3d origin;        ///< of the points, in the odometry frame
  std::size_t expected;          ///< points, at most
};

/// Throws Error if images differ in size, focal lengths are not positive or the pose is not finite.
LiftPlan planOf(const Frame& frame, const LiftOptions& options);

/// Hands the points of a frame that count to `take`, and counts the others.
LiftCounts liftRows(const Frame& frame, const LabelSet& set, const LiftPlan& plan,
                    const std::function<void(const PointRow&)>& take);

// What is done with every pixel or point, in files of their own flags (row_loops.cpp).

/// A row of a depth image: p = (towards + x * across) * z + shift, with x the normalised image
/// coordinate of a pixel and z its planar depth.
struct RowOfRays {
  float first_x, step_x;  ///< x of pixel 0, and from pixel to pixel
  float y;                ///< normalised image coordinate of the row
  float towards[3], across[3], shift[3];
  bool depth_is_range;  ///< along the ray instead of planar
  float min_range2, max_range2;
};

enum : std::uint8_t { kMeasured = 0, kNoDepth = 1, kOutOfRange = 2 };

/// Where the pixels of a row are, how far from the sensor, and whether they count (kMeasured...).
/// Points and ranges of pixels without depth mean nothing.
void projectRow(const RowOfRays& row, const float* depth, std::size_t width, float* x, float* y,
                float* z, float* range, std::uint8_t* state);

/// floor(p * per_unit + start), or kNoCell for what is not finite or does not fit.
constexpr std::int32_t kNoCell = 1 << 30;
void cellsOf(const float* p, std::size_t count, double per_unit, double start, std::int32_t* cell);

/// Whether each value differs from the one before it; added to what `differs` holds. The first one
/// is left as it is.
void markChanges(const std::uint32_t* values, std::size_t count, std::uint8_t* differs);

/// How many depths are measured (positive and finite), and how many of them lie in (above, upto].
struct DepthCounts {
  std::size_t measured = 0, within = 0;
};
DepthCounts countDepths(const float* depth, std::size_t count, float above, float upto);

}  // namespace xview::graph
