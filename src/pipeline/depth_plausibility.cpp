// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/depth_plausibility.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "xview/types/error.h"

namespace xview {
namespace {

constexpr double kFewLifted = 0.02;     ///< less of what was measured in range is no unusual recording any more
constexpr float kSmallRange_m = 5;      ///< half of a frame nearer than this: a room, or a wrong scale
constexpr int kSamplesAcross = 48;      ///< pixels compared per row and column
constexpr double kTolerance = 0.05;     ///< of two depths of one point
constexpr double kMoved_m = 0.5;        ///< poses at least so far apart tell scales apart
constexpr std::size_t kMostFramesOn = 10;
constexpr double kSeen = 0.05;          ///< share of pixels that both frames see
constexpr double kAgree = 0.7;          ///< share of these that agree if the scale is right: 0.85 to 1.00 in towns, noisy ones included
constexpr double kContradict = 0.6;     ///< and if it is ten times too small, over that share: 0.1 to 0.5 near the ground

float medianOf(std::vector<float> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

bool isDepth(float z) { return z > 0 && z < 1e9f; }

/// Of all that was measured, whatever its class and range [m].
float medianMeasured(const Frame& frame) {
  std::vector<float> values;
  for (const float z : frame.depth.pixels) {
    if (isDepth(z)) values.push_back(z);
  }
  for (const pcl::PointXYZL& p : frame.cloud.points) {
    if (p.getVector3fMap().allFinite()) values.push_back(p.getVector3fMap().norm());
  }
  return medianOf(std::move(values));
}

/// p_sensor of a pixel with this depth, and back.
struct Pinhole {
  const Camera& camera;
  Eigen::Vector3d unproject(int u, int v, double depth) const {
    const Eigen::Vector3d ray((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1);
    return camera.depth_is_range ? Eigen::Vector3d(ray.normalized() * depth) : Eigen::Vector3d(ray * depth);
  }
  double depthOf(const Eigen::Vector3d& p_sensor) const { return camera.depth_is_range ? p_sensor.norm() : p_sensor.z(); }
};

/// Whether a frame measures a point about where it is: within the tolerance in one of 3x3 pixels, as surfaces seen at a grazing angle
/// change by more from pixel to pixel. None if the point is out of view.
std::optional<bool> isMeasuredAt(const Frame& frame, const Eigen::Vector3d& p_sensor, double scale) {
  if (p_sensor.z() <= 0) return std::nullopt;
  const double u = frame.camera.fx * p_sensor.x() / p_sensor.z() + frame.camera.cx;
  const double v = frame.camera.fy * p_sensor.y() / p_sensor.z() + frame.camera.cy;
  if (!(u > 1 && v > 1 && u < frame.depth.width - 2 && v < frame.depth.height - 2)) return std::nullopt;
  const double expected = Pinhole{frame.camera}.depthOf(p_sensor);
  for (int dv = -1; dv <= 1; ++dv) {
    for (int du = -1; du <= 1; ++du) {
      const float z = frame.depth.at(static_cast<int>(std::lround(u)) + du, static_cast<int>(std::lround(v)) + dv);
      if (isDepth(z) && std::abs(expected / (scale * z) - 1) < kTolerance) return true;
    }
  }
  return false;
}

struct FramePair {
  std::size_t a, b;
};

/// Pairs in three places of the recording between which the sensor has moved.
std::vector<FramePair> movedPairs(const FrameSource& source) {
  std::vector<FramePair> pairs;
  for (const std::size_t quarter : {1u, 2u, 3u}) {
    const std::size_t a = quarter * source.size() / 4;
    for (std::size_t b = a + 1; b < std::min(source.size(), a + kMostFramesOn); ++b) {
      if ((source.pose(a).translation() - source.pose(b).translation()).norm() < kMoved_m) continue;
      pairs.push_back({a, b});
      break;
    }
  }
  return pairs;
}

/// The mean of the pairs.
DepthAgreement agreementOf(const std::vector<std::pair<Frame, Frame>>& pairs, double scale) {
  DepthAgreement mean;
  for (const auto& [a, b] : pairs) {
    const DepthAgreement one = agreementOfDepths(a, b, scale);
    mean.visible += one.visible / static_cast<double>(pairs.size());
    mean.agreeing += one.agreeing / static_cast<double>(pairs.size());
  }
  return mean;
}

/// How many times larger depths would have to be for frames to agree; none if they agree as they are, or do not tell.
std::optional<int> missingFactor(const FrameSource& source) {
  if (source.sensor() != Sensor::camera) return std::nullopt;
  std::vector<std::pair<Frame, Frame>> pairs;
  for (const FramePair& pair : movedPairs(source)) pairs.emplace_back(source.read(pair.a), source.read(pair.b));
  const double as_given = agreementOf(pairs, 1).agreeing;
  double best = as_given;
  std::optional<int> factor;
  for (const int candidate : {10, 100, 1000}) {
    const DepthAgreement agreement = agreementOf(pairs, candidate);
    if (agreement.visible < kSeen || agreement.agreeing <= best) continue;
    best = agreement.agreeing;
    factor = candidate;
  }
  return best >= kAgree && as_given <= kContradict * best ? factor : std::nullopt;
}

std::string scaleHint(const FrameSource& source, float median_m) {
  if (source.sensor() != Sensor::camera) return fmt::format("half of the points are beyond {:.4g} m; are their coordinates in metres?", median_m);
  return fmt::format("the median depth is {:.4g} m with depth_scale {:g}; is that scale right?", median_m,
                     source.read(source.size() / 2).camera.depth_scale);
}

}  // namespace

DepthAgreement agreementOfDepths(const Frame& a, const Frame& b, double scale) {
  const Eigen::Isometry3d T_b_a = b.T_odom_sensor.inverse() * a.T_odom_sensor;
  const Pinhole camera{a.camera};
  int compared = 0, visible = 0, agreeing = 0;
  const int step_u = std::max(1, a.depth.width / kSamplesAcross), step_v = std::max(1, a.depth.height / kSamplesAcross);
  for (int v = step_v / 2; v < a.depth.height; v += step_v) {
    for (int u = step_u / 2; u < a.depth.width; u += step_u) {
      const float depth = a.depth.at(u, v);
      if (!isDepth(depth)) continue;
      ++compared;
      const auto measured = isMeasuredAt(b, T_b_a * camera.unproject(u, v, scale * depth), scale);
      visible += measured.has_value();
      agreeing += measured.value_or(false);
    }
  }
  DepthAgreement result;
  if (compared > 0) result.visible = static_cast<double>(visible) / compared;
  if (visible > 0) result.agreeing = static_cast<double>(agreeing) / visible;
  return result;
}

void DepthPlausibility::add(const FrameDigest& frame) {
  counts_.lifted += frame.counts.lifted;
  counts_.out_of_range += frame.counts.out_of_range;
  if (!frame.cloud.ranges.empty()) median_ranges_.push_back(medianOf(frame.cloud.ranges));
}

void DepthPlausibility::require(const FrameSource& source) const {
  const auto measured = static_cast<double>(counts_.lifted + counts_.out_of_range);
  if (measured > 0 && static_cast<double>(counts_.lifted) < kFewLifted * measured) {
    throw Error(source.name(), fmt::format("{:.1f} % of the measurements are out of range (lift.min_range_m to lift.max_range_m): {}",
                                           100.0 * static_cast<double>(counts_.out_of_range) / measured,
                                           scaleHint(source, medianMeasured(source.read(source.size() / 2)))));
  }
  if (median_ranges_.empty() || medianOf(median_ranges_) > kSmallRange_m) return;
  if (const auto factor = missingFactor(source)) {
    throw Error(source.name(), fmt::format("depths contradict the poses, but would agree with them if they were {} times as large: {}", *factor,
                                           scaleHint(source, medianMeasured(source.read(source.size() / 2)))));
  }
}

}  // namespace xview
