// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/depth_agreement.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace xview {
namespace {

constexpr int kSamplesAcross = 48;   ///< pixels compared per row and column
constexpr double kTolerance = 0.05;  ///< of two depths of one point
constexpr double kMoved_m = 0.5;     ///< poses at least so far apart tell scales apart
constexpr std::size_t kMostFramesOn = 10;

bool isDepth(float z) { return z > 0 && z < 1e9f; }

/// p_sensor of a pixel with this depth, and back.
struct Pinhole {
  const Camera& camera;
  Eigen::Vector3d unproject(int u, int v, double depth) const {
    const Eigen::Vector3d ray((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1);
    return camera.depth_is_range ? Eigen::Vector3d(ray.normalized() * depth)
                                 : Eigen::Vector3d(ray * depth);
  }
  double depthOf(const Eigen::Vector3d& p_sensor) const {
    return camera.depth_is_range ? p_sensor.norm() : p_sensor.z();
  }
};

/// Whether a frame measures a point about where it is: within the tolerance in one of 3x3 pixels,
/// as surfaces seen at a grazing angle change by more from pixel to pixel. None if the point is out
/// of view.
std::optional<bool> isMeasuredAt(const Frame& frame, const Eigen::Vector3d& p_sensor,
                                 double scale) {
  if (p_sensor.z() <= 0) return std::nullopt;
  const double u = frame.camera.fx * p_sensor.x() / p_sensor.z() + frame.camera.cx;
  const double v = frame.camera.fy * p_sensor.y() / p_sensor.z() + frame.camera.cy;
  if (!(u > 1 && v > 1 && u < frame.depth.width - 2 && v < frame.depth.height - 2))
    return std::nullopt;
  const double expected = Pinhole{frame.camera}.depthOf(p_sensor);
  for (int dv = -1; dv <= 1; ++dv) {
    for (int du = -1; du <= 1; ++du) {
      const float z = frame.depth.at(static_cast<int>(std::lround(u)) + du,
                                     static_cast<int>(std::lround(v)) + dv);
      if (isDepth(z) && std::abs(expected / (scale * z) - 1) < kTolerance) return true;
    }
  }
  return false;
}

}  // namespace

DepthAgreement agreementOfDepths(const Frame& a, const Frame& b, double scale) {
  const Eigen::Isometry3d T_b_a = b.T_odom_sensor.inverse() * a.T_odom_sensor;
  const Pinhole camera{a.camera};
  int compared = 0, visible = 0, agreeing = 0;
  const int step_u = std::max(1, a.depth.width / kSamplesAcross),
            step_v = std::max(1, a.depth.height / kSamplesAcross);
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

std::vector<FramePair> movedPairs(const FrameSource& source) {
  std::vector<FramePair> pairs;
  for (const std::size_t quarter : {1u, 2u, 3u}) {
    const std::size_t a = quarter * source.size() / 4;
    for (std::size_t b = a + 1; b < std::min(source.size(), a + kMostFramesOn); ++b) {
      if ((source.pose(a).translation() - source.pose(b).translation()).norm() < kMoved_m) continue;
      pairs.emplace_back(source.read(a), source.read(b));
      break;
    }
  }
  return pairs;
}

DepthAgreement agreementOf(const std::vector<FramePair>& pairs, double scale) {
  DepthAgreement mean;
  for (const auto& [a, b] : pairs) {
    const DepthAgreement one = agreementOfDepths(a, b, scale);
    mean.visible += one.visible / static_cast<double>(pairs.size());
    mean.agreeing += one.agreeing / static_cast<double>(pairs.size());
  }
  return mean;
}

}  // namespace xview
