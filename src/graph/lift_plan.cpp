// SPDX-License-Identifier: BSD-3-Clause
#include "lift_plan.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "row_loops.h"
#include "xview/types/error.h"

namespace xview {
namespace {

std::string sizeText(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

void checkPose(const Frame& frame) {
  if (!frame.T_odom_sensor.matrix().allFinite()) {
    throw Error("frame " + std::to_string(frame.number), "the pose is not finite");
  }
}

template <class ImageType>
void checkSize(const Frame& frame, const ImageType& image, const char* name) {
  if (image.width == frame.depth.width && image.height == frame.depth.height) return;
  throw Error("frame " + std::to_string(frame.number),
              std::string("expected the ") + name + " image to be as large as the depth image, " +
                  sizeText(frame.depth.width, frame.depth.height) + ", found " +
                  sizeText(image.width, image.height));
}

void checkImages(const Frame& frame) {
  checkSize(frame, frame.label, "label");
  if (!frame.instance.empty()) checkSize(frame, frame.instance, "instance");
  const Camera& camera = frame.camera;
  const bool positive = camera.fx > 0 && camera.fy > 0;
  if (!positive || !std::isfinite(camera.fx * camera.fy + camera.cx + camera.cy)) {
    throw Error("frame " + std::to_string(frame.number),
                "expected positive, finite focal lengths, found fx " + std::to_string(camera.fx) +
                    ", fy " + std::to_string(camera.fy));
  }
}

Eigen::Vector3d roundedToMetre(const Eigen::Vector3d& p) { return p.array().round(); }

/// The options and the camera itself; the stricter one counts.
double maxCameraRange(const DepthCounts& depths, const Camera& camera, const LiftOptions& options) {
  const bool is_aerial = depths.measured > 0 && depths.within * 10 < depths.measured;
  return std::min(options.max_range_m * (is_aerial ? kRangeFromTheAir : 1), camera.max_range_m);
}

DepthCounts nearDepths(const DepthImage& depth) {
  return countDepths(depth.pixels.data(), depth.pixels.size(), 0, kAerialQuantile_m);
}

}  // namespace

double maxCameraRange(const Frame& frame, const LiftOptions& options) {
  return maxCameraRange(nearDepths(frame.depth), frame.camera, options);
}

LiftPlan planOf(const Frame& frame, const LiftOptions& options) {
  checkPose(frame);
  const Eigen::Vector3d sensor = frame.T_odom_sensor.translation();
  if (frame.sensor == Sensor::camera) {
    checkImages(frame);
    const DepthCounts depths = nearDepths(frame.depth);
    return {{std::max(options.min_range_m, frame.camera.min_range_m),
             maxCameraRange(depths, frame.camera, options)},
            roundedToMetre(sensor),
            depths.measured};
  }
  const Eigen::Vector3d start = frame.T_odom_sensor * frame.cloud.origin;
  return {{options.min_range_m, options.max_range_m * kRangeOfLidar},
          roundedToMetre(frame.sensor == Sensor::lidar ? sensor : start),
          frame.cloud.size()};
}

}  // namespace xview
